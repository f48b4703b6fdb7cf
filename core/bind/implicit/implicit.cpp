// Implicit steps: neve._core.f32.ImplicitSolver and neve._core.f64.ImplicitSolver; for tests the second derivatives besides.
#include "bind/material_point.hpp"
#include "cpu/implicit/solver.hpp"
#include "cpu/passes/requirements.hpp"

namespace neve::bind {

namespace {

// dP = (d2Psi/dF2) : dF of one snow, pack by pack.
template <class T>
View<T> hessian_product(const std::string& name, const std::string& plasticity, const Numbers& constants,
                        const Matrices<T>& F, const Reals<T>& J_P, const Matrices<T>& dF, bool project,
                        bool flows) {
  using R = Lanes<T>;
  const std::size_t n = F.shape(0);
  if (J_P.shape(0) != n || dF.shape(0) != n) throw nb::value_error("F, J_P and dF differ in length");
  const Snow snow = snow_of(name, plasticity, constants);
  T* rows;
  auto out = fresh<T>(rows, {n, 3, 3});
  const R one = splat<R>(1);
  with_law(snow.law, [&](auto law) {
    using L = decltype(law);
    for (std::size_t p = 0; p < n; p += width<R>) {
      const int count = static_cast<int>(std::min<std::size_t>(width<R>, n - p));
      const auto q = L::template parameters<R>(snow, one, one);
      const Svd3<R> at = svd3(matrices<T>(F.data() + 9 * p, count));
      const R J = select(first_lanes<R>(count), load<R>(J_P.data() + p, count), one);
      const auto map = [&](const Mat3<R>& trial) { return L::return_map(trial, J, q).stress.tau; };
      Tangent<R> t = flows ? detail::flow_tangent(at.strain, map) : L::tangent(at.strain, J, q);
      if (project) t = projected(t);
      write_matrices<T>(rows + 9 * p,
                        detail::derivative(t, at.U, at.V, matrices<T>(dF.data() + 9 * p, count)), count);
    }
  });
  return out;
}

// H u of each u (blocks, 64, 3), and the diagonal of H, of snow as it is.
template <class T>
nb::tuple stiffness(const Model<T>& model, const State<T>& state, Grid<T>& grid, double dt,
                    const In<T, nb::shape<-1, -1, 64, 3>>& u, bool project) {
  require_sorted(model, state, grid);
  const std::size_t n = u.shape(0), blocks = grid.blocks.size(), size = 64 * blocks;
  if (u.shape(1) != blocks) throw nb::value_error("u is (n, blocks, 64, 3) with the blocks of the grid");
  T *products, *entries;
  auto out = fresh<T>(products, {n, blocks, 64, 3}), out_diagonal = fresh<T>(entries, {blocks, 64, 3});
  NodeField<T> from, to;
  Tangents<T> tangents;
  for (NodeField<T>* each : {&from, &to}) each->resize(blocks);
  const auto clear = [&](NodeField<T>& a) { std::fill_n(a.block(0), blocks * block_values, T(0)); };
  const auto write = [&](const NodeField<T>& a, T* rows) {
    for (std::size_t i = 0; i < size; ++i) std::copy_n(a.block(0) + 4 * i, 3, rows + 3 * i);
  };
  with_implicit_step<T>(model, state, grid, dt, nullptr, [&](const auto& step) {
    clear(from);
    step.linearise(from, 1, project, 1, tangents);
    for (std::size_t k = 0; k < n; ++k) {
      clear(to);
      for (std::size_t i = 0; i < size; ++i)
        std::copy_n(u.data() + 3 * (k * size + i), 3, from.block(0) + 4 * i);
      step.add_stiffness(tangents, from, to);
      write(to, products + 3 * k * size);
    }
    clear(to);
    step.add_diagonal(tangents, to, [](const Home&) { return true; });
    write(to, entries);
  });
  return nb::make_tuple(out, out_diagonal);
}

using Weights = std::map<std::string, std::vector<double>>;
using Regularity = std::optional<double>;

// `regularity`: r over the stiffness; else that of the law.
LearnedNet net_of(const std::string& law, const Weights& weights, const Regularity& regularity) {
  const auto of = [&](const char* name) {
    const auto found = weights.find(name);
    if (found == weights.end()) throw nb::value_error("a network has a, b, W, V, w, d and q");
    return found->second;
  };
  LearnedNet net{0, 0, 0, of("a"), of("b"), of("W"), of("V"), of("w"), of("d"), of("q")};
  with_law(place_of(Laws{}, law, "law"), [&](auto one) {
    net.told = told_of<decltype(one)>;
    net.regularity = regularity.value_or(regularity_of<decltype(one)>);
  });
  const std::size_t K = net.a.size(), H = net.w.size();
  if (K == 0 || K > most_hidden || H == 0 || H > most_hidden || net.b.size() != K || net.d.size() != H ||
      net.W.size() != H * (K + 2) || net.V.size() != H * std::size_t(net.context()) || net.q.size() != 2)
    throw nb::value_error("weights of a network do not fit each other");
  net.steps = static_cast<int>(K), net.hidden = static_cast<int>(H);
  return net;
}

// P of one snow at F, its energy expanded around F0, and its change by dF.
template <class T>
nb::tuple learned_response(const std::string& name, const Numbers& constants, const Weights& weights,
                           const Matrices<T>& F0, const Reals<T>& J_P, const Matrices<T>& F,
                           const Matrices<T>& dF, const Regularity& regularity) {
  using R = Lanes<T>;
  const std::size_t n = F.shape(0);
  if (J_P.shape(0) != n || dF.shape(0) != n || F0.shape(0) != n)
    throw nb::value_error("F0, J_P, F and dF differ in length");
  const Snow snow = snow_of(name, "snow", constants);
  const LearnedNet net = net_of(name, weights, regularity);
  T *rows, *changes;
  auto out = fresh<T>(rows, {n, 3, 3}), out_change = fresh<T>(changes, {n, 3, 3});
  const R one = splat<R>(1);
  with_law(snow.law, [&](auto law) {
    using L = decltype(law);
    if constexpr (is_learned<L>) {
      for (std::size_t p = 0; p < n; p += width<R>) {
        const int count = static_cast<int>(std::min<std::size_t>(width<R>, n - p));
        const auto q = L::template parameters<R>(snow, one, one);
        const Mat3<R> at0 = matrices<T>(F0.data() + 9 * p, count), at = matrices<T>(F.data() + 9 * p, count);
        const R J = select(first_lanes<R>(count), load<R>(J_P.data() + p, count), one);
        const auto end = L::return_map(at0, J, q);
        const auto from = expand(net, law, q, at0, hardens_within<L> ? J : end.J_P, end.stress.tau,
                                 detail::inverse_transposed(at0));
        const Svd3<R> split = svd3(at);
        const auto found = respond(net, law, q, at, split, from, true);
        write_matrices<T>(rows + 9 * p, found.P, count);
        write_matrices<T>(
            changes + 9 * p,
            detail::derivative(found.tangent, split.U, split.V, matrices<T>(dF.data() + 9 * p, count)),
            count);
      }
    } else {
      throw nb::value_error("no network can take this law's place");
    }
  });
  return nb::make_tuple(out, out_change);
}

template <class T>
void bind_implicit(nb::module_& m) {
  using S = ImplicitSolver<T>;
  nb::class_<S>(m, "ImplicitSolver", "Velocities of the nodes at the end of a step from implicit equations.")
      .def(
          "__init__",
          [](S* self, bool newton, double beta, bool project, double tolerance, int most_iterations,
             bool midpoint) {
            new (self) S;
            self->options = {newton, beta, project, tolerance, most_iterations, midpoint};
          },
          nb::kw_only(), nb::arg("newton"), nb::arg("beta"), nb::arg("project"), nb::arg("tolerance"),
          nb::arg("most_iterations"), nb::arg("midpoint"))
      .def(
          "solve",
          [](S& self, Model<T>& model, const State<T>& state, Grid<T>& grid, double dt) {
            require_sorted(model, state, grid);
            if (model.sleeps() || state.has_heat())
              throw nb::value_error("implicit steps know no sleep and no heat");
            if (self.options.midpoint && !model.bodies.solids.empty())
              throw nb::value_error("the midpoint rule knows no bodies");
            return self.solve(model, state, grid, dt);
          },
          nb::arg("model"), nb::arg("state"), nb::arg("grid"), nb::arg("dt"),
          nb::call_guard<nb::gil_scoped_release>(),
          "From momenta without force (p2g with dt = 0) to velocities at the end of a step of dt [s].")
      .def(
          "finish", [](S& self, State<T>& state) { self.late.add_to(state); }, nb::arg("state"),
          "Give particles that g2p has moved what the midpoint rule has left for them.")
      .def(
          "learn",
          [](S& self, const std::string& law, const Weights& weights, const Regularity& regularity) {
            self.learned.learn(place_of(Laws{}, law, "law"), net_of(law, weights, regularity));
          },
          nb::arg("law"), nb::arg("weights"), nb::arg("regularity") = nb::none(),
          "Take the return map of a law from a network: a, b, W, V, w, d and q, row by row; and r over the "
          "stiffness, unless it is to be the law's own.")
      .def_prop_rw(
          "diagonal", [](const S& self) { return self.options.diagonal; },
          [](S& self, bool on) { self.options.diagonal = on; },
          "Whether the diagonal of the stiffness preconditions snow that lies on what no snow moves.")
      .def_prop_ro("iterations", [](const S& self) { return self.report.iterations; })
      .def_prop_ro("rounds", [](const S& self) { return self.report.rounds; })
      .def_prop_ro("residual", [](const S& self) { return self.report.residual; })
      .def_prop_ro("contacts_settled", [](const S& self) { return self.report.contacts_settled; })
      .def_prop_ro("converged", [](const S& self) { return self.report.converged; });
  m.def(
      "learned_response", &learned_response<T>, nb::arg("name"), nb::arg("constants"), nb::arg("weights"),
      nb::arg("F0"), nb::arg("J_P"), nb::arg("F"), nb::arg("dF"), nb::arg("regularity") = nb::none(),
      "P (n, 3, 3) [Pa] at F (n, 3, 3) of the energy that a network expands around F0, and its change by dF; "
      "J_P (n,) at the start of the step.");
  m.def("hessian_product", &hessian_product<T>, nb::arg("name"), nb::arg("plasticity"), nb::arg("constants"),
        nb::arg("F"), nb::arg("J_P"), nb::arg("dF"), nb::arg("project"), nb::arg("flows") = false,
        "dP (n, 3, 3) [Pa] of F (n, 3, 3), J_P (n,) and dF (n, 3, 3) for one snow, as long as it does not "
        "flow; or of its return map, symmetric part.");
  m.def("stiffness", &stiffness<T>, nb::arg("model"), nb::arg("state"), nb::arg("grid"), nb::arg("dt"),
        nb::arg("u"), nb::arg("project"),
        "(H u (n, blocks, 64, 3), diagonal of H (blocks, 64, 3)) [kg] of velocities u (n, blocks, 64, 3) of "
        "the "
        "nodes, H dt^2 times the stiffness of elastic snow as it lies on the sorted grid.");
}

}  // namespace

void bind_implicit(nb::module_& f32, nb::module_& f64) {
  bind_implicit<float>(f32);
  bind_implicit<double>(f64);
}

}  // namespace neve::bind
