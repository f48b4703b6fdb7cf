// neve._core.BodyMotion and BodyDynamics: how bodies move, from arrays or from what the rigid-body engine keeps of them.
#include <nanobind/stl/string.h>

#include <string>

#include "bind/arrays.hpp"
#include "coupling/scripted_path.hpp"
#include "rigid/body_dynamics.hpp"

namespace neve::bind {

using namespace nb::literals;

namespace {

using rigid::BodyDynamics, rigid::Carried, rigid::EngineConstraints, rigid::EngineData, rigid::EngineModel;

// Arrays of the engine by their names, kept alive; read in place.
class Arrays {
 public:
  explicit Arrays(nb::dict by_name) : by_name_(std::move(by_name)) {}

  // `size`: how many numbers there are, at least.
  template <class E>
  void read(E*& out, const char* name, std::size_t size) const {
    const auto a = nb::cast<nb::ndarray<E, nb::c_contig, nb::device::cpu>>(nb::object(by_name_[name]), false);
    if (a.size() < size) throw nb::value_error((std::string(name) + " is too short").c_str());
    out = a.data();
  }
  std::size_t rows(const char* name) const { return nb::len(nb::object(by_name_[name])); }
  template <class N>
  N number(const char* name) const {
    return nb::cast<N>(nb::object(by_name_[name]));
  }

 private:
  nb::dict by_name_;
};

EngineModel engine_model(const Arrays& a) {
  EngineModel m;
  const std::size_t bodies = a.rows("body_rootid"), n = m.dofs = a.rows("dof_parentid");
  const std::size_t actuators = m.actuators = a.rows("actuator_biastype");
  m.trees = a.number<std::size_t>("ntree");
  m.affine = a.number<std::int32_t>("affine"), m.satisfied = a.number<std::int32_t>("satisfied");
  m.whole_kinds = a.number<std::uint32_t>("whole_kinds");
  m.bias_numbers = a.number<std::size_t>("bias_numbers");
  a.read(m.body_rootid, "body_rootid", bodies), a.read(m.body_parentid, "body_parentid", bodies);
  a.read(m.body_dofadr, "body_dofadr", bodies), a.read(m.body_dofnum, "body_dofnum", bodies);
  a.read(m.dof_parentid, "dof_parentid", n), a.read(m.dof_treeid, "dof_treeid", n);
  a.read(m.M_rownnz, "M_rownnz", n), a.read(m.M_rowadr, "M_rowadr", n);
  a.read(m.M_colind, "M_colind", n), a.read(m.dof_damping, "dof_damping", n);
  a.read(m.actuator_biastype, "actuator_biastype", actuators);
  a.read(m.actuator_biasprm, "actuator_biasprm", m.bias_numbers * actuators);
  a.read(m.actuator_forcelimited, "actuator_forcelimited", actuators);
  a.read(m.actuator_forcerange, "actuator_forcerange", 2 * actuators);
  return m;
}

EngineData engine_data(const Arrays& a, const EngineModel& model) {
  EngineData d;
  const std::size_t bodies = a.rows("xpos"), n = model.dofs, actuators = model.actuators;
  a.read(d.xpos, "xpos", 3 * bodies), a.read(d.xmat, "xmat", 9 * bodies);
  a.read(d.xipos, "xipos", 3 * bodies), a.read(d.subtree_com, "subtree_com", 3 * bodies);
  a.read(d.cdof, "cdof", 6 * n), a.read(d.cdof_dot, "cdof_dot", 6 * n);
  a.read(d.qvel, "qvel", n), a.read(d.qacc, "qacc", n);
  a.read(d.qfrc_smooth, "qfrc_smooth", n), a.read(d.qfrc_constraint, "qfrc_constraint", n);
  a.read(d.M, "M", n), a.read(d.actuator_force, "actuator_force", actuators);
  a.read(d.moment_rownnz, "moment_rownnz", actuators), a.read(d.moment_rowadr, "moment_rowadr", actuators);
  a.read(d.moment_colind, "moment_colind", 0), a.read(d.actuator_moment, "actuator_moment", 0);
  a.read(d.xfrc_applied, "xfrc_applied", 6 * bodies);
  return d;
}

// The constraints of the moment, whose arrays lie elsewhere after each step.
EngineConstraints engine_constraints(const Arrays& a, const EngineModel& model) {
  EngineConstraints c;
  c.count = a.rows("efc_type"), c.contacts = a.rows("contact_address");
  a.read(c.type, "efc_type", c.count), a.read(c.state, "efc_state", c.count);
  a.read(c.D, "efc_D", c.count), a.read(c.contact_address, "contact_address", c.contacts);
  const std::size_t rows = a.rows("efc_J_rownnz");
  a.read(c.J, "efc_J", rows ? rows : c.count * model.dofs);
  if (rows) {
    a.read(c.rownnz, "efc_J_rownnz", c.count), a.read(c.rowadr, "efc_J_rowadr", c.count);
    a.read(c.colind, "efc_J_colind", rows);
  }
  return c;
}

std::vector<Carried> carried(const In<std::int32_t, nb::shape<-1>>& bodies,
                             const In<double, nb::shape<-1, 3, 4>>& frames) {
  if (frames.shape(0) != bodies.shape(0)) throw nb::value_error("a frame for each solid is needed");
  std::vector<Carried> out(bodies.shape(0));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].body = std::size_t(bodies(i));
    std::copy_n(frames.data() + 12 * i, 12, out[i].frame.begin());
  }
  return out;
}

// Dynamics with the arrays that it reads.
struct Engine {
  Arrays model_arrays, data_arrays;
  BodyDynamics dynamics;

  Engine(const nb::dict& model, const nb::dict& data, std::vector<Carried> solids)
      : model_arrays(model),
        data_arrays(data),
        dynamics(engine_model(model_arrays), engine_data(data_arrays, engine_model(model_arrays)),
                 std::move(solids)) {}
};

template <std::size_t N>
View<double> rows(const std::vector<std::array<double, N>>& values) {
  double* out;
  auto a = fresh<double>(out, {values.size(), N});
  for (const auto& row : values) out = std::copy(row.begin(), row.end(), out);
  return a;
}

template <std::size_t N>
View<double> array_of(const std::array<double, N>& values) {
  double* out;
  auto a = fresh<double>(out, {N});
  std::copy(values.begin(), values.end(), out);
  return a;
}

// A leg is a row: its beginning and span, position, rotation, way, axis, angle, velocity, turning.
ScriptedPath scripted_path(const In<double, nb::shape<-1>>& starts,
                           const In<double, nb::shape<-1, 27>>& rows) {
  const std::size_t n = rows.shape(0);
  if (n != starts.shape(0) + 1) throw nb::value_error("a path has one leg more than starts");
  std::vector<ScriptedLeg> legs(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* from = rows.data() + 27 * i;
    const auto read = [&](auto& values) {
      std::copy_n(from, values.size(), values.begin());
      from += values.size();
    };
    ScriptedLeg& leg = legs[i];
    leg.begin = *from++, leg.span = *from++;
    read(leg.position), read(leg.rotation), read(leg.way), read(leg.axis);
    leg.angle = *from++;
    read(leg.velocity), read(leg.omega);
  }
  return {std::vector<double>(starts.data(), starts.data() + starts.shape(0)), std::move(legs)};
}

void bind_paths(nb::module_& m) {
  using Out = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
  nb::class_<ScriptedPath>(m, "ScriptedPath", "Where a script has a solid at any time.")
      .def(
          "__init__",
          [](ScriptedPath* self, const In<double, nb::shape<-1>>& starts,
             const In<double, nb::shape<-1, 27>>& legs) {
            new (self) ScriptedPath(scripted_path(starts, legs));
          },
          "starts"_a, "legs"_a)
      .def(
          "at",
          [](const ScriptedPath& self, double t) {
            const ScriptedPose now = self.at(t);
            double* out;
            auto rotation = fresh<double>(out, {3, 3});
            std::copy(now.rotation.begin(), now.rotation.end(), out);
            return nb::make_tuple(array_of(now.position), rotation, array_of(now.velocity),
                                  array_of(now.omega));
          },
          "time"_a)
      .def(
          "place",
          [](const ScriptedPath& self, double t, const Out& position, const Out& quaternion) {
            if (position.size() != 3 || quaternion.size() != 4)
              throw nb::value_error("a place is three numbers and four");
            const ScriptedPose now = self.at(t);
            const std::array<double, 4> q = quaternion_of(now.rotation);
            std::copy(now.position.begin(), now.position.end(), position.data());
            std::copy(q.begin(), q.end(), quaternion.data());
          },
          "time"_a, "position"_a, "quaternion"_a);
}

nb::object rotations(const BodyMotion& motion) {
  double* out;
  auto a = fresh<double>(out, {motion.count(), 3, 3});
  for (const auto& row : motion.rotations) out = std::copy(row.begin(), row.end(), out);
  return nb::cast(a);
}

nb::object mobility(const BodyMotion& motion) {
  double* out;
  const std::size_t n = 6 * motion.count();
  auto a = fresh<double>(out, {n, n});
  for (const BodyGroup& g : motion.groups) {
    const std::size_t rows = 6 * g.bodies.size();
    for (std::size_t r = 0; r < rows; ++r) {
      for (std::size_t c = 0; c < rows; ++c)
        out[n * (6 * g.bodies[r / 6] + r % 6) + 6 * g.bodies[c / 6] + c % 6] = g.mobility[r * rows + c];
    }
  }
  return nb::cast(a);
}

BodyMotion motion_of(const In<double, nb::shape<-1, 3>>& centres, const In<double, nb::shape<-1, 3, 3>>& R,
                     const In<double, nb::shape<-1, 6>>& rates, const In<double, nb::shape<-1, -1>>& A,
                     const In<double, nb::shape<-1, 6>>& acceleration) {
  BodyMotion out;
  const std::size_t n = centres.shape(0);
  if (R.shape(0) != n || rates.shape(0) != n || acceleration.shape(0) != n || A.shape(0) != 6 * n ||
      A.shape(1) != 6 * n)
    throw nb::value_error("a row for each body is needed, and a mobility of (6 n, 6 n)");
  out.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::copy_n(centres.data() + 3 * i, 3, out.centres[i].begin());
    std::copy_n(R.data() + 9 * i, 9, out.rotations[i].begin());
    std::copy_n(rates.data() + 6 * i, 6, out.start[i].begin());
    std::copy_n(acceleration.data() + 6 * i, 6, out.free[i].begin());
  }
  BodyGroup all;
  for (std::size_t i = 0; i < n; ++i) all.bodies.push_back(i);
  all.mobility.assign(A.data(), A.data() + A.size());
  out.groups = {std::move(all)};
  return out;
}

}  // namespace

void bind_rigid(nb::module_& m) {
  bind_paths(m);
  nb::class_<BodyMotion>(m, "BodyMotion")
      .def(
          "__init__",
          [](BodyMotion* self, const In<double, nb::shape<-1, 3>>& centres,
             const In<double, nb::shape<-1, 3, 3>>& R, const In<double, nb::shape<-1, 6>>& rates,
             const In<double, nb::shape<-1, -1>>& A, const In<double, nb::shape<-1, 6>>& acceleration) {
            new (self) BodyMotion(motion_of(centres, R, rates, A, acceleration));
          },
          "centres"_a, "rotations"_a, "rates"_a, "mobility"_a, "acceleration"_a)
      .def_prop_ro("centres", [](const BodyMotion& self) { return nb::cast(rows(self.centres)); })
      .def_prop_ro("rotations", &rotations)
      .def_prop_ro("rates", [](const BodyMotion& self) { return nb::cast(rows(self.start)); })
      .def_prop_ro("mobility", &mobility)
      .def_prop_ro("acceleration", [](const BodyMotion& self) { return nb::cast(rows(self.free)); })
      .def_prop_ro("groups", [](const BodyMotion& self) { return self.groups.size(); });
  nb::class_<Engine>(m, "BodyDynamics")
      .def(
          "__init__",
          [](Engine* self, const nb::dict& model, const nb::dict& data,
             const In<std::int32_t, nb::shape<-1>>& bodies, const In<double, nb::shape<-1, 3, 4>>& frames) {
            new (self) Engine(model, data, carried(bodies, frames));
          },
          "model"_a, "data"_a, "bodies"_a, "frames"_a)
      .def(
          "update",
          [](Engine& self, double h, const nb::object& constraints) {
            EngineConstraints held;
            if (!constraints.is_none())
              held = engine_constraints(Arrays(nb::cast<nb::dict>(constraints)), self.dynamics.model());
            self.dynamics.update(h, held);
          },
          "h"_a, "constraints"_a.none() = nb::none())
      .def(
          "apply",
          [](const Engine& self, const In<double, nb::shape<-1, 7>>& exchanged, double dt) -> nb::object {
            const std::size_t n = self.dynamics.motion().count();
            if (exchanged.shape(0) != n) throw nb::value_error("a row for each solid is needed");
            const std::size_t bad = self.dynamics.apply(exchanged.data(), dt);
            return bad < n ? nb::cast(bad) : nb::none();
          },
          "exchanged"_a, "dt"_a)
      .def_prop_ro(
          "motion", [](const Engine& self) -> const BodyMotion& { return self.dynamics.motion(); },
          nb::rv_policy::reference_internal);
}

}  // namespace neve::bind
