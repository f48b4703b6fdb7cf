// Solids of the model that are given by a grid, and what any solid of it says of points.
#pragma once

#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include "bind/arrays.hpp"
#include "bind/snow.hpp"
#include "mpm/model.hpp"

namespace neve::bind {

inline Contact contact_of(const std::string& s) {
  return word<Contact>(
      s, {{"sticky", Contact::sticky}, {"slip", Contact::slip}, {"separate", Contact::separate}}, "mode");
}

template <class T>
Solid<T>& add_solid(Model<T>& model, Shape shape, const std::string& mode, double mu_c) {
  Solid<T> s{};
  s.index = static_cast<int>(model.solids.size());
  s.shape = shape;
  s.mode = contact_of(mode);
  s.mu_c = T(mu_c);
  s.rotation = identity<T>();
  return model.solids.emplace_back(s);
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
    const int count = static_cast<int>(std::min<std::size_t>(width<R>, x.shape(0) - p));
    Vec3<R> at{};
    for (int l = 0; l < count; ++l) {
      for (std::size_t k = 0; k < 3; ++k)
        at[static_cast<int>(k)][l] = T(x(p + static_cast<std::size_t>(l), k));
    }
    const Surface<R> s = surface(solid, at);
    for (int l = 0; l < count; ++l) {
      *phi++ = double(s.phi[l]);
      for (int k = 0; k < 3; ++k) *normal++ = double(s.normal[k][l]);
    }
  }
  return nb::make_tuple(a, b);
}

template <class T>
void bind_shapes(nb::module_& m) {
  using M = Model<T>;
  auto c = nb::borrow<nb::class_<M>>(m.attr("Model"));
  c.def(
      "add_mesh_solid",
      [](M& self, std::shared_ptr<SdfGrid> grid, const std::string& mode, double mu_c) {
        add_solid(self, Shape::mesh, mode, mu_c).mesh = grid.get();
        self.shapes.push_back(std::move(grid));
      },
      nb::arg("grid"), nb::arg("mode"), nb::arg("mu_c"));
  c.def(
      "add_terrain_solid",
      [](M& self, std::shared_ptr<HeightField> field, const std::string& mode, double mu_c) {
        add_solid(self, Shape::terrain, mode, mu_c).terrain = field.get();
        self.shapes.push_back(std::move(field));
      },
      nb::arg("field"), nb::arg("mode"), nb::arg("mu_c"));
  c.def("surface", &surface_at<T>, nb::arg("index"), nb::arg("points"),
        "(phi (n,) [m], normal (n, 3)) of a solid at points of the world, in the precision of the step.");
}

}  // namespace neve::bind
