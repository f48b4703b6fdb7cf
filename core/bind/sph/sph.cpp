// Smoothed particle hydrodynamics: neve._core.f32.Sph and neve._core.f64.Sph.
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include "bind/arrays.hpp"
#include "bind/solids.hpp"
#include "sph/advance.hpp"
#include "sph/measure.hpp"
#include "sph/shear.hpp"
#include "sph/water/mixture.hpp"
#include "sph/water/wet_walls.hpp"

namespace neve::bind {

namespace {

template <class T>
struct Sph {
  Sph(std::size_t n, double support) : kernel(support) {
    state.resize(n), sums.resize(n), samples.resize(0), walls.resize(0);
  }
  CubicKernel<T> kernel;
  SphState<T> state;
  SphSums<T> sums;
  SphBoundarySamples<T> samples;
  SphBoundary<T> walls;
  SphSearch room;
  SphPairs<T> snow, boundary;
  SphFriction<T> friction;
  std::vector<Exchange> exchanged;
  bool listed = false;  // the pairs are those of the state

  void require_pairs() const {
    if (!listed) throw nb::value_error("call find_pairs() first");
  }
  void require_snows(const Model<T>& world) const {
    for (std::size_t p = 0; p < state.count; ++p) {
      if (state.material[p] >= world.snows.size())
        throw nb::value_error("a particle names a material that is not there");
    }
    for (std::size_t b = 0; b < samples.count; ++b) {
      if (std::size_t(samples.solid[b]) >= world.solids.size())
        throw nb::value_error("a boundary particle names a solid that is not there");
    }
  }
};

template <class T>
void find_pairs(Sph<T>& w, const Model<T>& world, double dt) {
  w.require_snows(world);
  w.sums.resize(w.state.count);
  w.samples.place(world, dt, w.walls);
  neve::find_pairs(w.kernel, w.state, w.walls, w.room, w.snow, w.boundary);
  neve::wet_walls(w.kernel, w.state, w.walls, w.boundary);
  w.listed = true;
}

template <class T>
SolveReport solve_pressure(Sph<T>& w, const Model<T>& world, double dt, double tolerance, double largest,
                           int most) {
  w.require_pairs();
  SolveLimits limits;
  limits.tolerance = tolerance, limits.largest = largest, limits.most = most;
  if (!w.state.has_water()) return neve::solve_pressure(w.state, w.snow, dt, limits, w.sums);
  return neve::solve_mixture(w.kernel, world, w.state, w.walls, w.snow, w.boundary, dt, limits, w.sums);
}

template <class T>
void set_boundary(Sph<T>& w, const In<double, nb::shape<-1, 3>>& x,
                  const In<double, nb::shape<-1, 3>>& normal, const In<std::int32_t, nb::shape<-1>>& solid) {
  const std::size_t n = x.shape(0);
  if (normal.shape(0) != n || solid.shape(0) != n)
    throw nb::value_error("x, normal and solid differ in length");
  for (std::size_t b = 0; b < n; ++b) {
    if (solid(b) < 0 || (b > 0 && solid(b) < solid(b - 1)))
      throw nb::value_error("the solids of boundary particles must rise, from 0");
  }
  w.samples.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    for (std::size_t k = 0; k < 3; ++k) {
      w.samples.x.column(int(k))[b] = T(x(b, k));
      w.samples.normal.column(int(k))[b] = T(normal(b, k));
    }
    w.samples.solid[b] = solid(b);
  }
  w.samples.set_volumes(w.kernel);
  w.listed = false;
}

// A vector of each particle, and what is computed from it.
template <class T>
Vectors<T> vectors_of(const Sph<T>& w, const In<double, nb::shape<-1, 3>>& u) {
  w.require_pairs();
  if (u.shape(0) != w.state.count) throw nb::value_error("u has a row for each particle");
  Vectors<T> out;
  out.resize(w.state.count);
  for (std::size_t p = 0; p < w.state.count; ++p) {
    for (std::size_t k = 0; k < 3; ++k) out.column(int(k))[p] = T(u(p, k));
  }
  return out;
}

template <class T>
void bind_columns(nb::class_<Sph<T>>& c) {
#define NEVE_FIELD(name)                            \
  c.def_prop_ro(#name, [](nb::handle self) {        \
    auto& w = nb::cast<Sph<T>&>(self);              \
    return view(w.state.name, w.state.count, self); \
  })
  NEVE_FIELD(x);
  NEVE_FIELD(v);
  NEVE_FIELD(F_E);
  NEVE_FIELD(m);
  NEVE_FIELD(V0);
  NEVE_FIELD(rho_birth);
  NEVE_FIELD(J_P);
  NEVE_FIELD(stiffness);
  NEVE_FIELD(strength);
  NEVE_FIELD(p_last);
  NEVE_FIELD(a_last);
  NEVE_FIELD(material);
  NEVE_FIELD(source);
  NEVE_FIELD(id);
#undef NEVE_FIELD
#define NEVE_FIELD(name)                           \
  c.def_prop_ro(#name, [](nb::handle self) {       \
    auto& w = nb::cast<Sph<T>&>(self);             \
    return view(w.sums.name, w.state.count, self); \
  })
  NEVE_FIELD(rho0);
  NEVE_FIELD(rho);
  NEVE_FIELD(lam);
  NEVE_FIELD(G);
  NEVE_FIELD(L);
  NEVE_FIELD(fill);
  NEVE_FIELD(p);
  NEVE_FIELD(given);
  NEVE_FIELD(pressed);
  NEVE_FIELD(sheared);
#undef NEVE_FIELD
  c.def_prop_ro("boundary_x",
                [](nb::handle self) {
                  auto& w = nb::cast<Sph<T>&>(self);
                  return view(w.walls.x, w.walls.count, self);
                })
      .def_prop_ro("boundary_v",
                   [](nb::handle self) {
                     auto& w = nb::cast<Sph<T>&>(self);
                     return view(w.walls.v, w.walls.count, self);
                   })
      .def_prop_ro("boundary_V", [](nb::handle self) {
        auto& w = nb::cast<Sph<T>&>(self);
        return view(w.walls.V, w.walls.count, self);
      });
}

template <class T>
void bind_stages(nb::class_<Sph<T>>& c) {
  using W = Sph<T>;
  const auto free_gil = nb::call_guard<nb::gil_scoped_release>();
  c.def("find_pairs", &find_pairs<T>, nb::arg("solids"), nb::arg("dt") = 0.0, free_gil)
      .def(
          "find_densities",
          [](W& w, const Model<T>& world) {
            w.require_pairs();
            neve::find_densities(w.kernel, world, w.state, w.walls, w.snow, w.boundary, w.sums);
            neve::fill_water(w.kernel, w.state, w.walls, w.snow, w.boundary, w.sums);
          },
          nb::arg("solids"), free_gil)
      .def(
          "correct_gradients",
          [](W& w, const Model<T>& world) {
            w.require_pairs();
            neve::correct_gradients(w.state, world, w.walls, w.snow, w.boundary, w.sums);
            neve::look_across(w.state, w.snow, w.sums);
          },
          nb::arg("solids"), free_gil)
      .def(
          "find_given",
          [](W& w, const Model<T>& world, double dt) {
            w.require_pairs();
            w.samples.place(world, dt, w.walls);
            neve::reorder(w.walls, w.room.order_of_walls);
            neve::find_given(w.kernel, world, w.state, w.walls, w.boundary, dt, w.sums, w.friction);
          },
          nb::arg("solids"), nb::arg("dt"), free_gil)
      .def("solve_pressure", &solve_pressure<T>, nb::arg("solids"), nb::arg("dt"), nb::arg("tolerance"),
           nb::arg("largest"), nb::arg("most"), free_gil)
      .def(
          "solve_shear",
          [](W& w, double dt, double tolerance, int most) {
            w.require_pairs();
            SolveLimits limits;
            limits.tolerance = tolerance, limits.most = most;
            return neve::solve_shear(w.state, w.snow, dt, limits, w.sums);
          },
          nb::arg("dt"), nb::arg("tolerance"), nb::arg("most"), free_gil)
      .def(
          "advance",
          [](W& w, const Model<T>& world, double dt, double way, double strain) {
            w.require_pairs();
            if (w.friction.drag.size() != w.boundary.begin.back())
              throw nb::value_error("call find_given() first");
            SphAdvance<T> advance(world, w.state, w.walls, w.snow, w.boundary, w.friction, w.sums,
                                  w.kernel.h / 2, dt);
            const SphReport report = advance({way, strain}, w.exchanged);
            w.listed = !report.taken;
            return report;
          },
          nb::arg("solids"), nb::arg("dt"), nb::arg("way"), nb::arg("strain"), free_gil);
}

template <class T>
void bind_measures(nb::class_<Sph<T>>& c) {
  using W = Sph<T>;
  c.def(
       "body_rate",
       [](const W& w, const Model<T>& world) {
         w.require_pairs();
         return neve::body_rate(world, w.state, w.walls, w.boundary, w.sums);
       },
       nb::arg("solids"))
      .def("stress_rate",
           [](const W& w) {
             w.require_pairs();
             return neve::stress_rate(w.kernel, w.state, w.sums);
           })
      .def(
          "velocity_gradient",
          [](W& w, const In<double, nb::shape<-1, 3>>& u) {
            using R = Lanes<T>;
            const Vectors<T> field = vectors_of(w, u);
            const auto at = [&](std::size_t p, int count) { return load_vector<R>(field, p, count); };
            detail::fill_quads(w.state.count, w.sums, at);
            Field<T, 9> found;
            found.resize(w.state.count);
            each_gradient(
                w.snow, w.sums, w.state.count, w.sums.walls, at, [](std::size_t, int) { return splat<R>(0); },
                [&](std::size_t p, int count, const Mat3<R>& D) { store_matrix(found, p, D, count); });
            T* out;
            auto D = fresh<T>(out, {w.state.count, 3, 3});
            for (std::size_t p = 0; p < w.state.count; ++p) {
              for (int k = 0; k < 9; ++k) *out++ = found.column(k / 3 + 3 * (k % 3))[p];
            }
            return D;
          },
          nb::arg("u"))
      .def(
          "totals", [](const W& w, const Model<T>& world) { return totals(world.gravity, w.state, w.sums); },
          nb::arg("solids"))
      .def(
          "take_exchanged", [](W& w, std::size_t solids) { return take_exchanged(w.exchanged, solids); },
          nb::arg("solids"));
}

template <class T>
void bind_of(nb::module_& m) {
  using W = Sph<T>;
  nb::class_<W> c(m, "Sph", "Snow as smoothed particles, and the boundary particles of solids.");
  bind_columns(c);
  bind_stages(c);
  bind_measures(c);
  c.def(
       "__init__",
       [](W* self, std::size_t count, double support) {
         if (!(support > 0)) throw nb::value_error("support must be above 0");
         new (self) W(count, support);
       },
       nb::arg("count"), nb::arg("support"))
      .def_prop_ro("count", [](const W& w) { return w.state.count; })
      .def_prop_ro("support", [](const W& w) { return w.kernel.h; })
      .def_prop_ro("pairs",
                   [](const W& w) { return std::array{w.snow.begin.back(), w.boundary.begin.back()}; })
      .def_prop_ro("boundary_kernels", [](const W& w) { return w.samples.evaluated; })
      .def_prop_ro(
          "bytes",
          [](W& w) { return w.state.bytes() + w.sums.bytes() + w.snow.bytes() + w.boundary.bytes(); })
      .def(
          "set_water",
          [](W& w, int material, double rho0, double bulk_modulus, double viscosity) {
            if (material < 0 || !(rho0 > 0) || !(bulk_modulus > 0) || !(viscosity >= 0))
              throw nb::value_error(
                  "water needs a row, a density and a bulk modulus above 0, no viscosity below 0");
            w.state.water = {material, rho0, bulk_modulus, viscosity};
            w.listed = false;
          },
          nb::arg("material"), nb::arg("rho0"), nb::arg("bulk_modulus"), nb::arg("viscosity"))
      .def("set_boundary", &set_boundary<T>, nb::arg("x"), nb::arg("normal"), nb::arg("solid"));
}

}  // namespace

void bind_sph(nb::module_& m, nb::module_& f32, nb::module_& f64) {
  nb::class_<SolveReport>(m, "SolveReport", "How a solve ended.")
      .def_ro("iterations", &SolveReport::iterations)
      .def_ro("residual", &SolveReport::residual)
      .def_ro("largest", &SolveReport::largest)
      .def_ro("converged", &SolveReport::converged);
  nb::class_<SphReport>(m, "SphReport", "What the end of a step found.")
      .def_ro("speed", &SphReport::speed)
      .def_ro("strain_rate", &SphReport::strain_rate)
      .def_ro("finite", &SphReport::finite)
      .def_ro("taken", &SphReport::taken);
  nb::class_<SphTotals>(m, "SphTotals", "Sums over the snow, in double.")
      .def_ro("mass", &SphTotals::mass)
      .def_prop_ro("momentum",
                   [](const SphTotals& t) { return std::vector<double>(t.momentum, t.momentum + 3); })
      .def_ro("kinetic", &SphTotals::kinetic)
      .def_ro("elastic", &SphTotals::elastic)
      .def_ro("potential", &SphTotals::potential);
  bind_of<float>(f32);
  bind_of<double>(f64);
}

}  // namespace neve::bind
