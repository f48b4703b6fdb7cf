// The solids of a model: their shapes, where they are, which of them the snow moves, and what they say of points.
#pragma once

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "bind/arrays.hpp"
#include "bind/snow.hpp"
#include "bind/words.hpp"
#include "coupling/exchange.hpp"
#include "coupling/scripted_path.hpp"
#include "geometry/height_field.hpp"
#include "geometry/sdf_grid.hpp"
#include "mpm/model.hpp"

namespace neve::bind {

inline ContactMode contact_of(const std::string& s) {
  return word<ContactMode>(
      s, {{"sticky", ContactMode::sticky}, {"slip", ContactMode::slip}, {"separate", ContactMode::separate}},
      "mode");
}

template <class T>
Vec3<T> vec(const In<double, nb::shape<3>>& a) {
  return {T(a.data()[0]), T(a.data()[1]), T(a.data()[2])};
}

// An owner of samples and what the step sees of it.
template <class Owner, class View>
struct Shared {
  std::shared_ptr<Owner> owner;
  View view;
};
template <class View, class T, class Owner>
const View* keep(Model<T>& model, std::shared_ptr<Owner> owner) {
  const View view = owner->view();
  auto shared = std::make_shared<const Shared<Owner, View>>(Shared<Owner, View>{std::move(owner), view});
  model.shapes.push_back(shared);
  return &shared->view;
}

// `thickness`: how far apart opposite sides are, typically [m].
template <class T>
Solid<T>& add_solid(Model<T>& model, Shape shape, const std::string& mode, double mu_c, double thickness) {
  Solid<T> s{};
  s.index = int(model.solids.size());
  s.kind = shape;
  s.mode = contact_of(mode);
  s.mu_c = T(mu_c);
  s.rotation = identity<T>();
  s.margin = T(margin_of(thickness, model.dx));
  return model.solids.emplace_back(s);
}

// What was exchanged with each of `solids`, (solids, 7), and nothing from then on.
inline nb::object take_exchanged(std::vector<Exchange>& exchanged, std::size_t solids) {
  exchanged.resize(solids);
  double* out;
  auto a = fresh<double>(out, {solids, 7});
  for (const Exchange& e : exchanged) {
    for (double value : e.impulse) *out++ = value;
    for (double value : e.moment) *out++ = value;
    *out++ = e.work;
  }
  exchanged.assign(solids, Exchange{});
  return nb::cast(a);
}

// phi (n,) and normals (n, 3) of a solid in its place, by packs as in the step.
template <class T>
nb::tuple surface_at(const Model<T>& model, std::size_t index, const In<double, nb::shape<-1, 3>>& x) {
  using R = Lanes<T>;
  const Solid<T>& solid = model.solids.at(index);
  double *phi, *normal;
  auto a = fresh<double>(phi, {x.shape(0)});
  auto b = fresh<double>(normal, {x.shape(0), 3});
  for (std::size_t p = 0; p < x.shape(0); p += width<R>) {
    const int count = int(std::min<std::size_t>(width<R>, x.shape(0) - p));
    Vec3<R> at{};
    for (int l = 0; l < count; ++l) {
      for (std::size_t k = 0; k < 3; ++k) at[int(k)][l] = T(x(p + std::size_t(l), k));
    }
    const Surface<R> s = neve::surface(solid, at);
    for (int l = 0; l < count; ++l) {
      *phi++ = double(s.phi[l]);
      for (int k = 0; k < 3; ++k) *normal++ = double(s.normal[k][l]);
    }
  }
  return nb::make_tuple(a, b);
}

// Put a solid in its place: its frame's origin, rotation row by row, and how it moves.
template <class T>
void place(Model<T>& model, std::size_t i, const double* centre, const double* rotation,
           const double* velocity, const double* omega) {
  const auto vector = [](const double* a) { return Vec3<T>{T(a[0]), T(a[1]), T(a[2])}; };
  Solid<T>& s = model.solids.at(i);
  s.centre = vector(centre);
  for (int k = 0; k < 3; ++k) s.centre_beyond[k] = T(centre[k] - double(s.centre[k]));
  for (int k = 0; k < 9; ++k) s.rotation(k / 3, k % 3) = T(rotation[k]);
  s.velocity = vector(velocity), s.omega = vector(omega);
  if (s.body < 0) return;
  Twist& start = model.bodies.start[std::size_t(s.body)];
  for (std::size_t k = 0; k < 3; ++k) start[k] = velocity[k], start[3 + k] = omega[k];
}

// Put all bodies in their place, and keep how they move in the next step. `reach`: of each body's surface from its frame's
// origin. Returns a bound on the speed of their surfaces.
template <class T>
double move_bodies(Model<T>& model, const BodyMotion& motion, const double* reach, std::size_t count) {
  const std::size_t n = model.bodies.solids.size();
  if (motion.count() != n || count != n) throw nb::value_error("a row for each body is needed");
  static_cast<BodyMotion&>(model.bodies) = motion;
  double fastest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double *v = motion.start[i].data(), *w = v + 3;
    place(model, std::size_t(model.bodies.solids[i]), motion.centres[i].data(), motion.rotations[i].data(), v,
          w);
    const double speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]),
                 turning = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    fastest = std::max(fastest, speed + turning * reach[i]);
  }
  return fastest;
}

// Put solid i where its path has it at time t [s]. `reach`: as in move_bodies(), endless for what has no end. Returns a bound on the
// speed of its surface, of an endless one the speed of its frame's origin [m/s].
template <class T>
double follow(Model<T>& model, std::size_t i, const ScriptedPath& path, double t, double reach) {
  const ScriptedPose now = path.at(t);
  place(model, i, now.position.data(), now.rotation.data(), now.velocity.data(), now.omega.data());
  const auto length = [](const std::array<double, 3>& a) {
    return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  };
  return length(now.velocity) + (std::isfinite(reach) ? length(now.omega) * reach : 0.0);
}

// Where solids are, and which of them the snow moves.
template <class T>
void bind_motion(nb::class_<Model<T>>& c) {
  using M = Model<T>;
  c.def(
       "place_solid",
       [](M& self, std::size_t i, const In<double, nb::shape<3>>& centre,
          const In<double, nb::shape<3, 3>>& rotation, const In<double, nb::shape<3>>& velocity,
          const In<double, nb::shape<3>>& omega) {
         place(self, i, centre.data(), rotation.data(), velocity.data(), omega.data());
       },
       nb::arg("index"), nb::arg("centre"), nb::arg("rotation"), nb::arg("velocity"), nb::arg("omega"))
      .def("follow", &follow<T>, nb::arg("index"), nb::arg("path"), nb::arg("time"), nb::arg("reach"))
      .def(
          "move_bodies",
          [](M& self, const BodyMotion& motion, const In<double, nb::shape<-1>>& reach) {
            return move_bodies(self, motion, reach.data(), reach.shape(0));
          },
          nb::arg("motion"), nb::arg("reach"),
          "Place all bodies and say how they move in the next step; returns a bound on the speed of their "
          "surfaces, of which `reach` says how far they are from the origins of the frames.")
      .def(
          "set_belt",
          [](M& self, std::size_t i, const In<double, nb::shape<3>>& velocity) {
            self.solids.at(i).belt = vec<T>(velocity);
          },
          nb::arg("index"), nb::arg("velocity"),
          "Let the flat faces of a solid move along themselves like a belt: its velocity past the solid, in "
          "the axes of the world.")
      .def(
          "make_dynamic",
          [](M& self, std::size_t i) {
            self.solids.at(i).body = int(self.bodies.solids.size());
            self.bodies.solids.push_back(int(i));
            self.bodies.resize(self.bodies.solids.size());
          },
          nb::arg("index"), "Make a solid a body, moved by forces: the next of the bodies.");
}

template <class T>
void bind_solids(nb::class_<Model<T>>& c) {
  using M = Model<T>;
  constexpr double endless = std::numeric_limits<double>::max();
  c.def(
       "add_solid",
       [](M& self, const std::string& shape, const In<double, nb::shape<3>>& half, const std::string& mode,
          double mu_c) {
         const Vec3<T> h = vec<T>(half);
         const Shape s = value_of<Shape>(shape, shape_names, "shape");
         if (is_sampled(s)) throw nb::value_error(("shape '" + shape + "' has samples").c_str());
         add_solid(self, s, mode, mu_c, double(thickness_of(s, h))).half = h;
       },
       nb::arg("shape"), nb::arg("half"), nb::arg("mode"), nb::arg("mu_c"))
      .def(
          "add_mesh_solid",
          [](M& self, std::shared_ptr<SdfGrid> grid, const std::string& mode, double mu_c, double thickness) {
            add_solid(self, Shape::mesh, mode, mu_c, thickness).mesh = keep<SdfView>(self, std::move(grid));
          },
          nb::arg("grid"), nb::arg("mode"), nb::arg("mu_c"), nb::arg("thickness") = endless)
      .def(
          "add_terrain_solid",
          [](M& self, std::shared_ptr<HeightField> field, const std::string& mode, double mu_c) {
            add_solid(self, Shape::terrain, mode, mu_c, endless).terrain =
                keep<HeightView>(self, std::move(field));
          },
          nb::arg("field"), nb::arg("mode"), nb::arg("mu_c"))
      .def("surface", &surface_at<T>, nb::arg("index"), nb::arg("points"),
           "(phi (n,) [m], normal (n, 3)) of a solid at points of the world, in the precision of the step.");
  bind_motion<T>(c);
}

}  // namespace neve::bind
