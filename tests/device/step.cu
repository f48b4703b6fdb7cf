// The step of one particle and of one node as device code: every law x transfer x spline, and every contact mode, in both
// precisions. A compile test, not a back end: the lists are those of the core, so that what is new there is compiled here.
#include "constitutive/laws.hpp"
#include "math/bspline.hpp"
#include "mpm/node_update.hpp"
#include "mpm/particle_report.hpp"
#include "transfer/transfers.hpp"

namespace neve::device {

// Columns, `stride` apart.
template <class T>
struct Column {
  T* at;
  std::size_t stride;
  T& operator()(int k, std::size_t p) const { return at[static_cast<std::size_t>(k) * stride + p]; }
};
template <class T>
struct Solids {
  const Solid<T>*first, *last;
  const Solid<T>* begin() const { return first; }
  const Solid<T>* end() const { return last; }
};

template <class T>
struct Step {
  Column<T> x, v, C, F_E, modes, tau, J_P, m, V0, stiffness, strength;
  Column<T> nodes, change;  // (m v, m) or (v, m) and (f, -) or (dv, -), four per node
  Solids<T> solids;
  Snow snow;
  int transfer, spline, transfer_modes;
  double dx, dt, alpha;
  T gravity;
  double* impulse;
  unsigned* offending;
};

template <class T>
struct Particle {
  const Step<T>& s;
  std::size_t p;
  Vec3<T> vector(const Column<T>& f) const { return {f(0, p), f(1, p), f(2, p)}; }
  Mat3<T> matrix(const Column<T>& f) const {
    Mat3<T> a;
    for (int k = 0; k < 9; ++k) a(k % 3, k / 3) = f(k, p);
    return a;
  }
  Vec3<T> x() const { return vector(s.x); }
  Vec3<T> v() const { return vector(s.v); }
  Mat3<T> C() const { return matrix(s.C); }
  Mat3<T> F_E() const { return matrix(s.F_E); }
  Sym3<T> tau() const {
    return {s.tau(0, p), s.tau(1, p), s.tau(2, p), s.tau(3, p), s.tau(4, p), s.tau(5, p)};
  }
  T J_P() const { return s.J_P(0, p); }
  T m() const { return s.m(0, p); }
  T V0() const { return s.V0(0, p); }
};

// One weight of each kind of an axis, at four nodes.
template <class Weights, class Spline, class T>
struct Stencil {
  int base[3];
  T w[3][Weights::count][4];
  Stencil(const Vec3<T>& x, T per_dx) {
    for (int a = 0; a < 3; ++a) {
      const T u = x[a] * per_dx - T(Spline::shift), first = floor(u);
      base[a] = static_cast<int>(first);
      Weights::template axis<Spline>(u - first, w[a]);
    }
  }
  // f(node, i, j, k) for each node.
  template <class F>
  void each_node(F&& f) const {
    for (int n = 0; n < Spline::nodes * Spline::nodes * Spline::nodes; ++n) {
      const int i = n / (Spline::nodes * Spline::nodes), j = n / Spline::nodes % Spline::nodes,
                k = n % Spline::nodes;
      f(static_cast<std::size_t>((base[0] + i) * 4096 + (base[1] + j) * 64 + base[2] + k), i, j, k);
    }
  }
};

template <class Law, class T>
__noinline__ Mapped<T> return_map(const Mat3<T>& F_trial, T J_P, const Step<T>& s, std::size_t p) {
  const auto q = Law::parameters(s.snow, s.stiffness(0, p), s.strength(0, p));
  Mapped<T> out = Law::return_map(F_trial, J_P, q);
  out.stress.modulus += Law::stress(out.F_E, out.J_P, q).modulus + Law::energy(out.F_E, out.J_P, q);
  return out;
}

template <class Transfer, class Spline, class T>
__noinline__ void scatter(const Step<T>& s, std::size_t p) {
  const auto step = StepConstants<T>::template of<Spline>(s.dx, s.dt, s.alpha);
  const Particle<T> particle{s, p};
  const Contribution<T> given =
      contribution<Transfer>(particle.v(), particle.m(), particle.C(), particle.tau(), particle.V0(), step);
  Mat3<T> force{};
  if constexpr (Transfer::has_change) force = Transfer::force(particle.tau(), particle.V0(), step.cells);
  const Stencil<typename Transfer::ScatterWeights, Spline, T> st(particle.x(), step.cells.gradient);
  st.each_node([&](std::size_t node, int i, int j, int k) {
    const T wx = st.w[0][0][i], wy = st.w[1][0][j], wz = st.w[2][0][k], w = wx * wy * wz;
    const Vec3<T> g{st.w[0][1][i] * wy * wz, wx * st.w[1][1][j] * wz, wx * wy * st.w[2][1][k]};
    Vec3<T> momentum = given.momentum * w;
    if constexpr (Transfer::has_matrix) momentum = momentum + given.A * g;
    if constexpr (Transfer::modes > 4) {
      for (int n = 4; n < Transfer::modes; ++n) {
        const int* d = Transfer::order[n].degree;
        const T weight = st.w[0][d[0]][i] * st.w[1][d[1]][j] * st.w[2][d[2]][k] * given.mass;
        for (int a = 0; a < 3; ++a) momentum[a] += weight * s.modes(3 * (n - 4) + a, p);
      }
    }
    for (int a = 0; a < 3; ++a) atomicAdd(&s.nodes(a, node), momentum[a]);
    atomicAdd(&s.nodes(3, node), given.mass * w);
    if constexpr (Transfer::has_change) {
      const Vec3<T> f = force * g;
      for (int a = 0; a < 3; ++a) atomicAdd(&s.change(a, node), f[a]);
    }
  });
}

template <class Law, class Transfer, class Spline, class T>
__noinline__ void gather(const Step<T>& s, std::size_t p) {
  const auto step = StepConstants<T>::template of<Spline>(s.dx, s.dt, s.alpha);
  const Particle<T> particle{s, p};
  const Stencil<typename Transfer::GatherWeights, Spline, T> st(particle.x(), step.cells.gradient);
  Gathered<T> grid{};
  st.each_node([&](std::size_t node, int i, int j, int k) {
    const T wx = st.w[0][0][i], wy = st.w[1][0][j], wz = st.w[2][0][k], w = wx * wy * wz;
    const Vec3<T> v{s.nodes(0, node), s.nodes(1, node), s.nodes(2, node)};
    grid.v = grid.v + v * w;
    grid.G = grid.G + Mat3<T>{v * (st.w[0][1][i] * wy * wz), v * (wx * st.w[1][1][j] * wz),
                              v * (wx * wy * st.w[2][1][k])};
    const Vec3<T> dv{s.change(0, node), s.change(1, node), s.change(2, node)};
    grid.change = grid.change + dv * w;
    grid.G_change = grid.G_change + Mat3<T>{dv * (st.w[0][1][i] * wy * wz), dv * (wx * st.w[1][1][j] * wz),
                                            dv * (wx * wy * st.w[2][1][k])};
  });
  const Advanced<T> now = advance<Transfer>(
      particle, grid, step, s.solids,
      [&](const Mat3<T>& F_trial, const T& J_P) { return return_map<Law>(F_trial, J_P, s, p); },
      [&](const auto& solid, auto met, const Vec3<T>& arm, const Vec3<T>&, const Vec3<T>& before,
          const Vec3<T>& after) {
        if (met) atomicAdd(s.impulse + solid.index, double(particle.m() * dot(after - before, arm)));
      });
  Extremes<T> extremes;
  if (extremes.add_step(true, now, particle.m(), particle.V0(), step) > T(0)) atomicAdd(s.offending, 1u);
  if (extremes.report().rejected()) atomicAdd(s.offending, 1u);
  if constexpr (Transfer::modes > 4) {
    Vec3<T> kept;
    if constexpr (Transfer::squares) {
      for (int a = 0; a < 3; ++a) kept[a] = Transfer::template kept<Spline>(particle.x()[a], now.x[a]);
    }
    for (int n = 4; n < Transfer::modes; ++n) {
      const Vec3<T> c = Transfer::template coefficient<Spline>(n, grid.v, kept);
      for (int a = 0; a < 3; ++a) s.modes(3 * (n - 4) + a, p) = c[a];
    }
  }
  const Sym3<T>& tau = now.material.stress.tau;
  const T stress[6] = {tau.xx, tau.yy, tau.zz, tau.xy, tau.xz, tau.yz};
  for (int k = 0; k < 3; ++k) s.x(k, p) = now.x[k], s.v(k, p) = now.v[k];
  for (int k = 0; k < 9; ++k) {
    s.F_E(k, p) = now.material.F_E(k % 3, k / 3);
    if constexpr (Transfer::keeps_C) s.C(k, p) = now.C(k % 3, k / 3);
  }
  for (int k = 0; k < 6; ++k) s.tau(k, p) = stress[k];
  s.J_P(0, p) = now.material.J_P;
}

// Steps 4 to 6 of one node, with and without a change that is kept.
template <class T>
__noinline__ void update_node(const Step<T>& s, std::size_t i, const Vec3<T>& x) {
  const T m = s.nodes(3, i), inverse_m = inverse_mass(m);
  if (!has_velocity(m)) return;
  Vec3<T> v;
  for (int a = 0; a < 3; ++a) {
    s.change(a, i) = velocity_change(a == 2 ? s.gravity : T(0), s.change(a, i), inverse_m, T(s.dt));
    v[a] = node_velocity(s.nodes(a, i), inverse_m, s.change(a, i));
  }
  NoLift none;
  v = collide(s.solids, x, v, none, T(skin_cells * s.dx), T(s.dt), m, [&](const auto&, const auto&...) {});
  for (int a = 0; a < 3; ++a) s.nodes(a, i) = v[a];
}

// Each contact mode by name: a solid's mode is a number that is known at run time only.
template <ContactMode mode, class T>
__noinline__ void contact(const Step<T>& s, std::size_t p) {
  const Particle<T> particle{s, p};
  const Vec3<T> v = particle.v(), n = particle.x(), still{};
  const Vec3<T> after =
      after_contact(v, flat(n), still, mode, T(0.3)) + contact_slope(v, n, still, mode, T(0.3)) * v;
  for (int a = 0; a < 3; ++a) s.v(a, p) = after[a];
}

// Every transfer of the list with every number of modes that it may have.
template <class Spline, class T>
void transfers(const Step<T>& s, std::size_t p) {
  with_transfer(s.transfer, s.transfer_modes, [&](auto transfer) {
    scatter<decltype(transfer), Spline>(s, p);
    each(Laws{}, [&](auto law) { gather<decltype(law), decltype(transfer), Spline>(s, p); });
  });
}

template <class T>
void all(const Step<T>& s) {
  const std::size_t p = blockIdx.x * blockDim.x + threadIdx.x;
  each(Splines{}, [&](auto spline) { transfers<decltype(spline)>(s, p); });
  update_node(s, p, Particle<T>{s, p}.x());
  contact<ContactMode::sticky>(s, p);
  contact<ContactMode::slip>(s, p);
  contact<ContactMode::separate>(s, p);
}

}  // namespace neve::device

extern "C" __global__ void step_float32(neve::device::Step<float> s) { neve::device::all(s); }
extern "C" __global__ void step_float64(neve::device::Step<double> s) { neve::device::all(s); }
