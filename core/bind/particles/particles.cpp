// The discrete element method: neve._core.f32.Particles and neve._core.f64.Particles.
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include "bind/arrays.hpp"
#include "bind/solids.hpp"
#include "particles/advance.hpp"
#include "particles/heat/phase.hpp"
#include "particles/measure.hpp"
#include "particles/relax.hpp"

namespace neve::bind {

namespace {

template <class T>
struct Particles {
  explicit Particles(std::size_t n) { state.resize(n); }
  ParticleModel<T> model;
  HeatModel heat;
  std::vector<ContactMaterial> table;
  ParticleState<T> state;
  Neighbours<T> lists;
  RebuildRoom<T> room;
  PairQuads<T> quads;
  PairSums<T> sums;
  std::vector<Exchange> exchanged;
  bool current = false;  // the lists hold all pairs that can touch

  void require_lists() const {
    if (lists.begin.size() != state.count + 1) throw nb::value_error("call rebuild() first");
  }
};

template <class T>
ParticleReport step(Particles<T>& p, const Model<T>& solids, double dt) {
  p.require_lists();
  pair_forces(p.state, p.lists, p.model.law, p.quads, p.sums);
  const ParticleReport report = advance(p.model, solids, p.state, p.lists, p.sums, dt, p.exchanged);
  p.model.law.dt = T(dt);
  p.current = report.moved <= 0.5 * p.lists.skin;
  return report;
}

// What is remembered of pairs: begin (n + 1,), and of each entry the row of the other particle and four numbers.
template <class T>
nb::tuple contacts(const Particles<T>& p) {
  const Neighbours<T>& lists = p.lists;
  std::vector<std::uint32_t> begin{0};
  std::vector<std::int32_t> row;
  std::vector<T> values;
  for (std::size_t i = 0; i + 1 < lists.begin.size(); ++i) {
    for (std::uint32_t e = lists.begin[i]; e < lists.begin[i + 1]; ++e) {
      if (lists.hold[e] == T(0)) continue;
      row.push_back(lists.row[e]);
      for (const auto* of : {&lists.hold, &lists.a, &lists.b, &lists.c}) values.push_back((*of)[e]);
    }
    begin.push_back(std::uint32_t(row.size()));
  }
  const std::size_t n = row.size(), count = begin.size();
  return nb::make_tuple(array(std::move(begin), {count}), array(std::move(row), {n}),
                        array(std::move(values), {n, 4}));
}

template <class T>
void set_contacts(Particles<T>& p, const In<std::uint32_t, nb::shape<-1>>& begin,
                  const In<std::int32_t, nb::shape<-1>>& row, const In<T, nb::shape<-1, 4>>& values) {
  const std::size_t n = row.shape(0), count = p.state.count;
  bool right = begin.shape(0) == count + 1 && values.shape(0) == n && begin(0) == 0 && begin(count) == n;
  for (std::size_t i = 0; right && i < count; ++i) right = begin(i) <= begin(i + 1) && begin(i + 1) <= n;
  for (std::size_t e = 0; right && e < n; ++e) right = row(e) >= 0 && std::size_t(row(e)) < count;
  if (!right) throw nb::value_error("the contacts are not those of these particles");
  p.current = false;
  p.lists = Neighbours<T>{};
  p.lists.begin.assign(begin.data(), begin.data() + count + 1);
  p.lists.resize(n);
  std::copy_n(row.data(), n, p.lists.row.begin());
  for (std::size_t e = 0; e < n; ++e) {
    p.lists.hold[e] = values(e, 0), p.lists.a[e] = values(e, 1);
    p.lists.b[e] = values(e, 2), p.lists.c[e] = values(e, 3);
  }
}

template <class T>
void bind_columns(nb::class_<Particles<T>>& c) {
#define NEVE_FIELD(name)                            \
  c.def_prop_ro(#name, [](nb::handle self) {        \
    auto& p = nb::cast<Particles<T>&>(self);        \
    return view(p.state.name, p.state.count, self); \
  })
  NEVE_FIELD(x);
  NEVE_FIELD(v);
  NEVE_FIELD(m);
  NEVE_FIELD(V0);
  NEVE_FIELD(radius);
  NEVE_FIELD(J_P);
  NEVE_FIELD(stiffness);
  NEVE_FIELD(strength);
  NEVE_FIELD(liquid);
  NEVE_FIELD(enthalpy);
  NEVE_FIELD(k);
  NEVE_FIELD(bond);
  NEVE_FIELD(material);
  NEVE_FIELD(source);
  NEVE_FIELD(id);
#undef NEVE_FIELD
}

template <class T>
void bind_constants(nb::class_<Particles<T>>& c) {
  using P = Particles<T>;
  c.def(
       "set_law",
       [](P& p, double damping, double tangential, double ice, double hardening) {
         p.model.law.damping = T(damping), p.model.law.tangential = T(tangential);
         p.model.ice = ice, p.model.hardening = hardening;
       },
       nb::arg("damping"), nb::arg("tangential"), nb::arg("ice"), nb::arg("hardening"))
      .def(
          "set_materials",
          [](P& p, const In<double, nb::shape<-1, 4>>& rows) {
            std::vector<ContactMaterial> table;
            for (std::size_t i = 0; i < rows.shape(0); ++i)
              table.push_back({rows(i, 0), rows(i, 1), rows(i, 2), rows(i, 3)});
            for (std::size_t i = 0; i < p.state.count; ++i) {
              if (p.state.material[i] >= table.size())
                throw nb::value_error("a particle names a material that is not there");
            }
            p.table = table;
            derive(p.state, table);
          },
          nb::arg("rows"), "(n, 4): modulus [Pa], friction [1], bond_strain [1], yield [Pa].");
}

template <class T>
void bind_heat(nb::class_<Particles<T>>& c) {
  using P = Particles<T>;
  c.def(
       "set_heat",
       [](P& p, double air, double exchange, double sun, std::array<double, 3> towards, double conductivity,
          double speed,
          bool sinters) { p.heat = {air, exchange, sun, towards, conductivity, speed, sinters}; },
       nb::arg("air"), nb::arg("exchange"), nb::arg("sun"), nb::arg("towards"), nb::arg("conductivity"),
       nb::arg("speed"), nb::arg("sinters"))
      .def(
          "pass_heat",
          [](P& p, double dt) {
            p.require_lists();
            if (p.table.empty()) throw nb::value_error("call set_materials() first");
            return pass_heat(p.heat, p.state, p.lists, p.table, dt);
          },
          nb::arg("dt"), nb::call_guard<nb::gil_scoped_release>());
}

template <class T>
void bind_of(nb::module_& m) {
  using P = Particles<T>;
  const auto free_gil = nb::call_guard<nb::gil_scoped_release>();
  nb::class_<P> c(m, "Particles",
                  "Particles of the discrete element method, and what is remembered of their pairs.");
  bind_columns(c);
  bind_constants(c);
  bind_heat(c);
  c.def(nb::init<std::size_t>(), nb::arg("count"))
      .def_prop_ro("count", [](const P& p) { return p.state.count; })
      .def_prop_ro("bytes", [](P& p) { return p.state.bytes() + p.lists.bytes() + p.sums.values.bytes(); })
      .def_prop_rw(
          "last_dt", [](const P& p) { return p.model.law.dt; }, [](P& p, T dt) { p.model.law.dt = dt; })
      .def(
          "rebuild",
          [](P& p, double near, double dt) {
            if (!(near > 0) || !(dt >= 0)) throw nb::value_error("near must be above 0, dt not below");
            rebuild(p.state, p.lists, p.room, near, dt);
            p.current = true;
          },
          nb::arg("near"), nb::arg("dt"), free_gil)
      .def_prop_ro("current", [](const P& p) { return p.current; })
      .def(
          "make_bonds",
          [](P& p, std::uint32_t first, double gap) {
            p.require_lists(), make_bonds(p.state, p.lists, first, T(gap));
          },
          nb::arg("first"), nb::arg("gap"))
      .def(
          "relax", [](P& p) { p.require_lists(), relax(p.state, p.lists); }, free_gil)
      .def(
          "stiffness_now", [](const P& p) { return p.require_lists(), stiffness_of(p.state, p.lists); },
          free_gil)
      .def("step", &step<T>, nb::arg("solids"), nb::arg("dt"), free_gil)
      .def(
          "totals",
          [](const P& p, const Model<T>& solids) {
            return p.require_lists(), totals(p.model.law, solids.gravity, p.state, p.lists);
          },
          nb::arg("solids"))
      .def("contacts", &contacts<T>)
      .def("set_contacts", &set_contacts<T>, nb::arg("begin"), nb::arg("row"), nb::arg("values"))
      .def(
          "take_exchanged", [](P& p, std::size_t solids) { return take_exchanged(p.exchanged, solids); },
          nb::arg("solids"));
}

}  // namespace

void bind_particles(nb::module_& m, nb::module_& f32, nb::module_& f64) {
  nb::class_<ParticleReport>(m, "ParticleReport", "What a step found.")
      .def_ro("speed", &ParticleReport::speed)
      .def_ro("stiffest", &ParticleReport::stiffest)
      .def_ro("moved", &ParticleReport::moved)
      .def_ro("finite", &ParticleReport::finite);
  nb::class_<ParticleTotals>(m, "ParticleTotals", "Sums over the particles, in double.")
      .def_ro("mass", &ParticleTotals::mass)
      .def_prop_ro("momentum",
                   [](const ParticleTotals& t) { return std::vector<double>(t.momentum, t.momentum + 3); })
      .def_ro("kinetic", &ParticleTotals::kinetic)
      .def_ro("elastic", &ParticleTotals::elastic)
      .def_ro("potential", &ParticleTotals::potential)
      .def_ro("bonds", &ParticleTotals::bonds)
      .def_ro("contacts", &ParticleTotals::contacts)
      .def_ro("heat", &ParticleTotals::heat)
      .def_ro("water", &ParticleTotals::water);
  nb::class_<HeatReport>(m, "HeatReport", "What a pass over the heat found.")
      .def_ro("taken", &HeatReport::taken)
      .def_ro("rounds", &HeatReport::rounds)
      .def_ro("endless", &HeatReport::endless)
      .def_ro("finite", &HeatReport::finite);
  bind_of<float>(f32);
  bind_of<double>(f64);
}

}  // namespace neve::bind
