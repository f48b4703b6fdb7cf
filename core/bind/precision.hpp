// The objects and stages of one precision: neve._core.f32 and neve._core.f64 are the same templates.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include "bind/arrays.hpp"
#include "bind/device/tables.hpp"
#include "bind/material_point.hpp"
#include "bind/snow.hpp"
#include "bind/solids.hpp"
#include "cpu/g2p.hpp"
#include "cpu/grid_update.hpp"
#include "cpu/heat/pass.hpp"
#include "cpu/p2g.hpp"
#include "cpu/passes/first_not_finite.hpp"
#include "cpu/passes/inspect.hpp"
#include "cpu/passes/refresh.hpp"
#include "cpu/passes/requirements.hpp"
#include "cpu/passes/totals.hpp"
#include "cpu/passes/volumes.hpp"
#include "cpu/sleep.hpp"
#include "mpm/population.hpp"

namespace neve::bind {

// What changes in time.
template <class T>
void bind_changes(nb::class_<Model<T>>& c) {
  using M = Model<T>;
  c.def(
       "set_snow",
       [](M& self, std::size_t row, const std::string& law, const std::string& plasticity,
          const Numbers& constants) {
         if (row >= self.snows.size()) throw nb::value_error("no such row of the material table");
         self.snows[row] = snow_of(law, plasticity, constants);
       },
       nb::arg("row"), nb::arg("law"), nb::arg("plasticity"), nb::arg("constants"))
      .def(
          "set_heat", [](M& self, const HeatModel& heat) { self.heat = heat; }, nb::arg("heat"))
      .def(
          "set_gravity",
          [](M& self, const In<double, nb::shape<3>>& gravity) { self.gravity = vec<T>(gravity); },
          nb::arg("gravity"));
}

template <class T>
void bind_model(nb::module_& m) {
  using M = Model<T>;
  nb::class_<M> c(m, "Model", "The constants of one run.");
  c.def(
       "__init__",
       [](M* self, double dx, const std::string& spline, const std::string& transfer, double flip_alpha,
          const In<double, nb::shape<3>>& gravity, int polypic_modes, std::optional<double> flip_damping,
          double sleep_speed, double sleep_after) {
         if (polypic_modes != 1 && polypic_modes != 4 && polypic_modes != 8 && polypic_modes != 27)
           throw nb::value_error("polypic_modes: 1, 4, 8 or 27");
         new (self) M{dx,
                      place_of(Splines{}, spline, "spline"),
                      place_of(Transfers{}, transfer, "transfer"),
                      polypic_modes,
                      flip_alpha,
                      flip_damping,
                      vec<T>(gravity),
                      {},
                      {},
                      {},
                      {},
                      sleep_speed,
                      sleep_after};
       },
       nb::arg("dx"), nb::arg("spline"), nb::arg("transfer"), nb::arg("flip_alpha"), nb::arg("gravity"),
       nb::arg("polypic_modes") = 8, nb::arg("flip_damping") = nb::none(), nb::arg("sleep_speed") = 0.0,
       nb::arg("sleep_after") = 0.0)
      .def_prop_ro("keeps_C", &keeps_C<T>, "Whether particles carry an affine velocity.")
      .def(
          "max_compression",
          [](const M& self, double strongest) {
            double least = std::numeric_limits<double>::infinity();
            for (const Snow& snow : self.snows) least = std::min(least, max_compression(snow, strongest));
            return least;
          },
          nb::arg("strongest"),
          "How far one step may compress any of the snows, -dt tr grad v [1], before hardening stores more "
          "than "
          "the work of the step; strongest: the largest factor on the thresholds of any particle [1].")
      .def_prop_ro(
          "stencil_stiffness", &stencil_stiffness<T>,
          "The largest sum over nodes of |g . a|^2 / w, g what makes velocity gradients [1/cells^2].")
      .def_prop_ro("more_modes", &velocities<T>,
                   "How many velocities a particle has beyond v and C: further modes, and how far it has "
                   "left surfaces with play.")
      .def_prop_ro(
          "has_play", [](const M& self) { return has_play(self); },
          "Whether the last of them is how far it has left surfaces with play [m].")
      .def(
          "add_snow",
          [](M& self, const std::string& law, const std::string& plasticity, const Numbers& constants) {
            self.snows.push_back(snow_of(law, plasticity, constants));
            self.has_elastic_snow = self.has_elastic_snow || !self.snows.back().plastic;
          },
          nb::arg("law"), nb::arg("plasticity"), nb::arg("constants"), "Add a row to the material table.")
      .def_ro("dx", &M::dx);
  bind_changes<T>(c);
  bind_solids<T>(c);
  bind_device<T>(m, c);
}

// Particles that come and go. Views of the arrays keep the rows that they had.
template <class T>
void bind_population(nb::class_<State<T>>& c) {
  using S = State<T>;
  c.def_prop_ro("capacity", &S::capacity)
      .def("with_room", &with_room<T>, nb::arg("capacity"))
      .def(
          "append",
          [](S& s, std::size_t n) {
            if (n > s.capacity() - s.count) throw nb::value_error("there is no room: see with_room()");
            s.resize(s.count + n);
          },
          nb::arg("n"))
      .def(
          "rows_in_box",
          [](const S& s, const In<double, nb::shape<3>>& low, const In<double, nb::shape<3>>& high) {
            std::vector<std::uint32_t> rows = rows_in_box(s, low.data(), high.data());
            const std::size_t n = rows.size();
            return array(std::move(rows), {n});
          },
          nb::arg("low"), nb::arg("high"))
      .def(
          "drop",
          [](S& s, const In<std::uint32_t, nb::shape<-1>>& rows) {
            const std::size_t n = rows.shape(0);
            for (std::size_t k = 0; k < n; ++k) {
              if (rows(k) >= s.count || (k > 0 && rows(k) <= rows(k - 1)))
                throw nb::value_error("rows must rise, each a row of a particle");
            }
            drop(s, rows.data(), n);
          },
          nb::arg("rows"));
}

template <class T>
void bind_state(nb::module_& m) {
  using S = State<T>;
  nb::class_<S> c(m, "State",
                  "Everything per particle; arrays are views of the core's memory, at fixed addresses.");
  c.def(
      "__init__",
      [](S* self, std::size_t count, int more_modes, bool sleeps, bool heat, bool fine) {
        if (more_modes < 0) throw nb::value_error("more_modes is negative");
        new (self) S(more_modes, sleeps, heat, fine);
        self->resize(count);
      },
      nb::arg("count"), nb::arg("more_modes") = 0, nb::arg("sleeps") = false, nb::arg("heat") = false,
      nb::arg("fine") = false);
  c.def_ro("count", &S::count);
  c.def_prop_ro("bytes", &S::bytes);
  bind_population<T>(c);
#define NEVE_FIELD(name)                     \
  c.def_prop_ro(#name, [](nb::handle self) { \
    S& s = nb::cast<S&>(self);               \
    return view(s.name, s.count, self);      \
  })
  NEVE_FIELD(x);
  NEVE_FIELD(v);
  NEVE_FIELD(C);
  NEVE_FIELD(modes);
  NEVE_FIELD(F_E);
  NEVE_FIELD(tau);
  NEVE_FIELD(J_P);
  NEVE_FIELD(m);
  NEVE_FIELD(V0);
  NEVE_FIELD(stiffness);
  NEVE_FIELD(strength);
  NEVE_FIELD(material);
  NEVE_FIELD(id);
#undef NEVE_FIELD
  const auto numbers = [](auto& columns, std::size_t n, nb::handle self) {
    using E = std::remove_reference_t<decltype(*columns.column(0))>;
    return View<E>(columns.column(0), {n, std::size_t(columns.components())}, self,
                   {1, std::int64_t(columns.stride())});
  };
#define NEVE_NUMBERS(name)                          \
  c.def_prop_ro(#name, [numbers](nb::handle self) { \
    S& s = nb::cast<S&>(self);                      \
    return numbers(s.name, s.count, self);          \
  })
  NEVE_NUMBERS(beyond);
  NEVE_NUMBERS(rest);
  NEVE_NUMBERS(enthalpy);
  NEVE_NUMBERS(thermal);
#undef NEVE_NUMBERS
}

// The nodes that carry mass: indices (n, 3), mass (n,), the three other numbers (n, 3).
template <class T>
nb::tuple nodes(Grid<T>& grid) {
  const auto each = [&](auto&& f) {
    for (std::size_t b = 0; b < grid.blocks.size(); ++b) {
      const T* node = grid.node(static_cast<std::int32_t>(b));
      const BlockCoord at = grid.blocks[b];
      for (int i = 0; i < 64; ++i) {
        if (node[4 * i + 3] > T(0))
          f(4 * at.x + i / 16, 4 * at.y + i / 4 % 4, 4 * at.z + i % 4, node + 4 * i);
      }
    }
  };
  std::size_t n = 0;
  each([&](int, int, int, const T*) { ++n; });
  std::int32_t* ijk;
  T *mass, *v;
  auto a = fresh<std::int32_t>(ijk, {n, 3});
  auto b = fresh<T>(mass, {n});
  auto c = fresh<T>(v, {n, 3});
  each([&](int i, int j, int k, const T* node) {
    *ijk++ = i, *ijk++ = j, *ijk++ = k;
    *mass++ = node[3];
    for (int d = 0; d < 3; ++d) *v++ = node[d];
  });
  return nb::make_tuple(a, b, c);
}

template <class T>
void bind_grid(nb::module_& m) {
  using G = Grid<T>;
  nb::class_<G>(m, "Grid", "The sparse grid: scratch, rebuilt in each step.")
      .def(nb::init<>())
      .def_prop_ro(
          "current", [](const G& g) { return g.current; }, "No particle has left its home since sort().")
      .def_prop_ro(
          "blocks", [](const G& g) { return g.blocks.size(); }, "Allocated blocks of 64 nodes.")
      .def_prop_ro(
          "homes", [](const G& g) { return g.moving; }, "Blocks that own particles which move.")
      .def(
          "look_at_all",
          [](G& grid, const Report& found, bool may_sleep) {
            grid.whole = true, grid.may_sleep = may_sleep;
            grid.rest_wave = found.wave, grid.rest_room = found.ice_room;
          },
          nb::arg("report"), nb::arg("may_sleep"),
          "Let the next sort see who sleeps; report: what a pass over all particles has found.")
      .def_prop_ro("bytes", &G::bytes)
      .def(
          "take_exchanged",
          [](G& grid, std::size_t solids) { return take_exchanged(grid.exchanged, solids); },
          "What snow and each of the solids exchanged since the last call, (solids, 7): impulse of the snow "
          "on the "
          "solid [N s], its moment about the solid's centre [N m s], work of the solid on the snow [J].")
      .def("nodes", &nodes<T>,
           "(ijk (n, 3), mass (n,), momentum after p2g or velocity after grid_update (n, 3)).");
}

// The stages of a step.
template <class T>
void bind_stages(nb::module_& m) {
  const auto free_gil = nb::call_guard<nb::gil_scoped_release>();
  m.def(
      "sort",
      [](const Model<T>& model, State<T>& state, Grid<T>& grid) {
        require_modes(model, state);
        sort(model, state, grid);
      },
      free_gil, "Sort the particles by block and cell, and lay out the grid for them.");
  m.def(
      "p2g",
      [](const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
        require_sorted(model, state, grid);
        with_spline(model.spline, [&](auto spline) {
          with_transfer(model, [&](auto transfer) {
            p2g<T, decltype(spline), decltype(transfer)>(model, state, grid, dt);
          });
        });
      },
      free_gil, "Scatter mass, momentum and force to the grid.");
  m.def(
      "give",
      [](const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
        require_sorted(model, state, grid);
        with_spline(model.spline, [&](auto spline) {
          with_transfer(model, [&](auto transfer) {
            give<T, decltype(spline), decltype(transfer)>(model, state, grid, dt);
          });
        });
      },
      free_gil, "Scatter the particles at the border of a rank, for it and for others; then follows p2g.");
  m.def(
      "grid_update",
      [](Model<T>& model, Grid<T>& grid, double dt) {
        if (grid.has_change != keeps_change(model)) throw nb::value_error("the grid is of another model");
        return grid_update(model, grid, dt);
      },
      free_gil,
      "Turn momenta into velocities: forces, gravity, collisions; report what they would do to the "
      "particles.");
  m.def(
      "g2p",
      [](const Model<T>& model, State<T>& state, Grid<T>& grid, double dt, bool commit) {
        require_sorted(model, state, grid);
        return with_spline(model.spline, [&](auto spline) {
          return with_transfer(model, [&](auto transfer) {
            return g2p<T, decltype(spline), decltype(transfer)>(model, state, grid, dt, commit);
          });
        });
      },
      nb::arg("model"), nb::arg("state"), nb::arg("grid"), nb::arg("dt"), nb::arg("commit") = true, free_gil,
      "Gather: deformation, plastic flow, velocities, collisions, positions; report what limits the time "
      "step. Without commit nothing is moved.");
}

// Passes over the particles outside the step.
template <class T>
void bind_passes(nb::module_& m) {
  const auto free_gil = nb::call_guard<nb::gil_scoped_release>();
  m.def(
      "refresh",
      [](const Model<T>& model, State<T>& state) {
        require_snow(model, state);
        return refresh(model, state);
      },
      free_gil, "Recompute the stress from F_E and J_P; report what limits the time step.");
  m.def(
      "volumes_from_grid",
      [](const Model<T>& model, State<T>& state, Grid<T>& grid) {
        require_sorted(model, state, grid);
        with_spline(model.spline,
                    [&](auto spline) { volumes_from_grid<T, decltype(spline)>(model, state, grid); });
      },
      free_gil, "Take each particle's rest volume from the density on the grid; call after p2g.");
  m.def(
      "totals",
      [](const Model<T>& model, const State<T>& state) {
        require_snow(model, state);
        require_modes(model, state);
        return totals(model, state);
      },
      free_gil, "Sum mass, momentum and energies in double precision.");
  m.def(
      "pass_heat",
      [](const Model<T>& model, State<T>& state, double dt) {
        require_snow(model, state);
        require_modes(model, state);
        if (!model.heat) throw nb::value_error("call set_heat() first");
        return pass_heat(model, state, dt);
      },
      nb::arg("model"), nb::arg("state"), nb::arg("dt"), free_gil,
      "Let heat flow for dt [s] of motion, and let the particles follow.");
  m.def("first_not_finite", &first_not_finite<T>, free_gil,
        "The row of the first particle with a value that is not finite, or -1.");
  m.def(
      "inspect",
      [](const Model<T>& model, const State<T>& state) {
        const Inspection found = inspect(model, state);
        return nb::make_tuple(found.row, found.field, found.densest, found.crowding);
      },
      nb::arg("model"), nb::arg("state"),
      "Of the particles: the row of the first with an impossible value, or -1, and its field; the row of the "
      "densest, and its density over that of ice, or over what else its pressing ends at.");
  m.def(
      "ice",
      [](const Reals<T>& z, double speed) {
        const auto of = [](auto a) { return Ice<decltype(a)>{splat<decltype(a)>(T(1))}; };
        const auto to_come = [&](auto a) { return of(a).modulus_to_come(a, splat<decltype(a)>(T(speed))); };
        return nb::make_tuple(each_lane<T>(z, [&](auto a) { return of(a).pressure(a); }),
                              each_lane<T>(z, [&](auto a) { return of(a).energy(a); }),
                              each_lane<T>(z, to_come));
      },
      nb::arg("z"), nb::arg("speed") = 0.0,
      "Pressure [Pa], energy [J/m3] and the acoustic modulus to come [Pa] of ice that changes z by speed / "
      "dx "
      "in a second, each over J_ice; z = ln(J_ice / J) >= 0; speed in m/s.");
}

template <class T>
void bind_precision(nb::module_& m) {
  bind_model<T>(m);
  bind_state<T>(m);
  bind_grid<T>(m);
  bind_stages<T>(m);
  bind_passes<T>(m);
  bind_material_point<T>(m);
}

}  // namespace neve::bind
