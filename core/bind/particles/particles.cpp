// The discrete element method: neve._core.f32.Particles and neve._core.f64.Particles.
#include <nanobind/stl/vector.h>

#include "bind/arrays.hpp"
#include "bind/solids.hpp"
#include "particles/heat/pass.hpp"
#include "particles/population.hpp"
#include "particles/relax.hpp"

namespace neve::bind {

namespace {

template <class T>
struct Particles : ParticleSnow<T> {
  explicit Particles(std::size_t n) { this->state.resize(n); }
  void require_lists() const {
    if (!this->listing.made_for(this->state.count)) throw nb::value_error("call prepare() first");
  }
  // What steps and heat need: lists, and what is kept beside them.
  void require_ready() const {
    require_lists();
    if (!this->quads.made_for(this->state.count)) throw nb::value_error("call prepare() first");
  }
};

template <class T>
ParticleReport step(Particles<T>& p, const Model<T>& solids, double dt) {
  p.require_ready();
  return take_step(p, solids, dt);
}

// What is remembered of pairs: begin (n + 1,), and of each entry the row of the other particle and four numbers.
template <class T>
nb::tuple contacts(Particles<T>& p) {
  p.require_lists(), p.remind();
  PairMemory<T> memory = memory_of(p.listing.lists);
  const std::size_t n = memory.row.size(), count = memory.begin.size();
  std::vector<T> values(4 * n);
  for (std::size_t e = 0; e < n; ++e)
    std::copy_n(memory.values[e].begin(), 4, values.begin() + 4 * std::ptrdiff_t(e));
  return nb::make_tuple(array(std::move(memory.begin), {count}), array(std::move(memory.row), {n}),
                        array(std::move(values), {n, 4}));
}

// Rows as an index, of which none is past the end.
template <class T>
std::vector<std::uint32_t> rows_of(const Particles<T>& p, const In<std::uint32_t, nb::shape<-1>>& rows) {
  std::vector<std::uint32_t> out(rows.data(), rows.data() + rows.shape(0));
  for (const std::uint32_t row : out)
    if (row >= p.state.count) throw nb::index_error("no particle has this row");
  return out;
}

template <class T>
Particles<T> with_particles(Particles<T>& p, const In<std::uint32_t, nb::shape<-1>>& kept, std::size_t more) {
  const std::vector<std::uint32_t> rows = rows_of(p, kept);
  if (std::adjacent_find(rows.begin(), rows.end(), std::greater_equal<>()) != rows.end())
    throw nb::value_error("the rows that are kept must rise");
  if (p.carried.begin.size() != p.state.count + 1) p.require_lists();
  Particles<T> out(0);
  take_over(out, p, rows, more);
  return out;
}

template <class T>
void set_contacts(Particles<T>& p, double near, const In<std::uint32_t, nb::shape<-1>>& begin,
                  const In<std::int32_t, nb::shape<-1>>& row, const In<T, nb::shape<-1, 4>>& values) {
  const std::size_t n = row.shape(0), count = p.state.count;
  bool right = begin.shape(0) == count + 1 && values.shape(0) == n && begin(0) == 0 && begin(count) == n;
  for (std::size_t i = 0; right && i < count; ++i) right = begin(i) <= begin(i + 1) && begin(i + 1) <= n;
  for (std::size_t i = 0; right && i < count; ++i) {  // the rows of each rise, below the number of particles
    for (std::size_t e = begin(i); right && e < begin(i + 1); ++e)
      right = row(e) > (e == begin(i) ? -1 : row(e - 1)) && std::size_t(row(e)) < count &&
              std::size_t(row(e)) != i;
  }
  if (!right) throw nb::value_error("the contacts are not those of these particles");
  PairMemory<T> memory;
  memory.begin.assign(begin.data(), begin.data() + count + 1);
  memory.row.assign(row.data(), row.data() + n);
  for (std::size_t e = 0; e < n; ++e)
    memory.values.push_back({values(e, 0), values(e, 1), values(e, 2), values(e, 3)});
  p.listing.near = near;
  list_all(p.state, p.listing, memory, false);
  see_sleepers(p.state, p.groups, true);
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
  NEVE_FIELD(rest);
  NEVE_FIELD(enthalpy);
  NEVE_FIELD(k);
  NEVE_FIELD(bond);
  NEVE_FIELD(born);
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
          [](P& p, const In<double, nb::shape<-1, 4>>& rows, double packing) {
            std::vector<ContactMaterial> table;
            for (std::size_t i = 0; i < rows.shape(0); ++i)
              table.push_back({rows(i, 0), rows(i, 1), rows(i, 2), rows(i, 3)});
            for (std::size_t i = 0; i < p.state.count; ++i) {
              if (p.state.material[i] >= table.size())
                throw nb::value_error("a particle names a material that is not there");
            }
            p.table = table;
            p.bounds = derive(p.state, table, packing);
          },
          nb::arg("rows"), nb::arg("packing"),
          "(n, 4): modulus [Pa], friction [1], bond_strain [1], yield [Pa].")
      .def(
          "set_sleep",
          [](P& p, double way, double after, double slow) {
            p.model.sleep.way = way, p.model.sleep.after = after, p.model.sleep.slow = slow;
          },
          nb::arg("way"), nb::arg("after"), nb::arg("slow"))
      .def_prop_rw(
          "may_sleep", [](const P& p) { return p.model.sleep.may_sleep; },
          [](P& p, bool may) { p.model.sleep.may_sleep = may; })
      .def_prop_ro("stiffest", [](const P& p) { return p.bounds.stiffest; })
      .def_prop_ro("largest_radius", [](const P& p) { return p.bounds.radius; })
      .def(
          "rate_of",
          [](const P& p, double stiffness) {
            return stable_rate(stiffness, stiffness * double(p.model.law.damping));
          },
          nb::arg("stiffness"));
}

template <class T>
void bind_heat(nb::class_<Particles<T>>& c) {
  using P = Particles<T>;
  c.def(
       "set_heat", [](P& p, const HeatModel& heat) { p.heat = heat; }, nb::arg("heat"))
      .def(
          "pass_heat",
          [](P& p, double dt, const Model<T>* solids) {
            p.require_ready();
            if (p.table.empty()) throw nb::value_error("call set_materials() first");
            static const std::vector<Solid<T>> none;
            return pass_heat(static_cast<ParticleSnow<T>&>(p), solids ? solids->solids : none, dt);
          },
          nb::arg("dt"), nb::arg("solids").none() = nb::none(), nb::call_guard<nb::gil_scoped_release>());
}

template <class T>
void bind_population(nb::class_<Particles<T>>& c) {
  using P = Particles<T>;
  c.def("with_particles", &with_particles<T>, nb::arg("kept"), nb::arg("more"))
      .def(
          "bond_newborn",
          [](P& p, std::uint32_t first, double gap) { p.require_ready(), bond_newborn(p, first, T(gap)); },
          nb::arg("first"), nb::arg("gap"))
      .def(
          "totals_of",
          [](P& p, const Model<T>& solids, const In<std::uint32_t, nb::shape<-1>>& rows) {
            p.remind();
            return totals_of(p.model.law, solids.gravity, p.state, p.listing.lists, rows_of(p, rows));
          },
          nb::arg("solids"), nb::arg("rows"));
}

template <class T>
std::size_t sleepers_in(const Particles<T>& p) {
  std::size_t sum = 0;
  for (std::size_t g = 0; g < p.groups.asleep.size(); ++g) {
    if (p.groups.asleep[g]) sum += detail::end_of_group(p.state, g) - g * p.groups.lanes;
  }
  return sum;
}

template <class T>
void bind_lists(nb::class_<Particles<T>>& c) {
  using P = Particles<T>;
  c.def_rw("order", &P::wide)
      .def_prop_ro("drift",
                   [](const P& p) {
                     const Vec3<double>& drift = p.listing.drift;
                     return std::vector<double>{drift.x, drift.y, drift.z};
                   })
      .def_prop_rw(
          "last_dt", [](const P& p) { return p.model.law.dt; }, [](P& p, T dt) { p.model.law.dt = dt; });
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
  bind_population(c);
  bind_lists(c);
  c.def(nb::init<std::size_t>(), nb::arg("count"))
      .def_prop_ro("count", [](const P& p) { return p.state.count; })
      .def_prop_ro("bytes", [](P& p) { return p.state.bytes() + p.listing.bytes() + p.sums.values.bytes(); })
      .def_prop_ro("asleep", [](const P& p) { return p.state.count == 0 ? 0 : sleepers_in(p); })
      .def(
          "prepare",
          [](P& p, double near, double dt) {
            if (!(near > 0) || !(dt >= 0)) throw nb::value_error("near must be above 0, dt not below");
            prepare(p, near, dt);
          },
          nb::arg("near"), nb::arg("dt"), free_gil)
      .def_prop_ro("is_due", [](const P& p) { return p.is_due(); })
      .def(
          "renew",
          [](P& p, const Model<T>& solids, std::int64_t steps) {
            p.require_ready(), renew(p, solids, steps);
          },
          nb::arg("solids"), nb::arg("steps"), free_gil)
      .def(
          "make_bonds",
          [](P& p, std::uint32_t first, double gap) {
            p.require_lists(), make_bonds(p.state, p.listing.lists, first, T(gap));
          },
          nb::arg("first"), nb::arg("gap"))
      .def(
          "relax", [](P& p) { p.require_lists(), relax(p.state, p.listing.lists); }, free_gil)
      .def(
          "stiffness_now",
          [](P& p) {
            p.require_ready();
            return stiffness_now(p.state, p.listing.lists, p.model.law, p.quads, p.groups, p.sums);
          },
          free_gil)
      .def("step", &step<T>, nb::arg("solids"), nb::arg("dt"), free_gil)
      .def(
          "totals",
          [](P& p, const Model<T>& solids) {
            p.require_lists(), p.remind();
            return totals(p.model.law, solids.gravity, p.state, p.listing.lists);
          },
          nb::arg("solids"))
      .def("contacts", &contacts<T>)
      .def("set_contacts", &set_contacts<T>, nb::arg("near"), nb::arg("begin"), nb::arg("row"),
           nb::arg("values"))
      .def(
          "take_exchanged", [](P& p, std::size_t solids) { return take_exchanged(p.exchanged, solids); },
          nb::arg("solids"));
}

}  // namespace

void bind_particles(nb::module_& m, nb::module_& f32, nb::module_& f64) {
  nb::class_<ParticleReport>(m, "ParticleReport", "What a step found.")
      .def_ro("speed", &ParticleReport::speed)
      .def_ro("stiffest", &ParticleReport::stiffest)
      .def_ro("rate", &ParticleReport::rate)
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
  bind_of<float>(f32);
  bind_of<double>(f64);
}

}  // namespace neve::bind
