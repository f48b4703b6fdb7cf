// The implicit solve for shear (Gissler et al. 2020, section 3.2).
#pragma once

#include "sph/conjugate_gradients.hpp"
#include "sph/phases.hpp"

namespace neve {

namespace detail {

// factor (S F + F S) of the symmetric part S of D, and a symmetric F.
template <class R>
Sym3<R> strained(const Mat3<R>& D, const Mat3<R>& F, const R& factor) {
  using T = scalar_t<R>;
  Mat3<R> S;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) S(r, c) = (D(r, c) + D(c, r)) * T(0.5);
  }
  const Mat3<R> B = S * F;
  return times(Sym3<R>{B(0, 0) * T(2), B(1, 1) * T(2), B(2, 2) * T(2), B(0, 1) + B(1, 0), B(0, 2) + B(2, 0),
                       B(1, 2) + B(2, 1)},
               factor);
}

template <class R>
Sym3<R> sum_of(const Sym3<R>& a, const Sym3<R>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}

// The parts of the solve for shear of one step.
template <class T>
class ShearSolve {
 public:
  using R = Lanes<T>;
  ShearSolve(const SphState<T>& s, const SphPairs<T>& snow, T dt, SphSums<T>& sums)
      : s_(s), snow_(snow), dt_(dt), sums_(sums) {}

  // The stress of F*, in `sums.s`, and over which boundaries it acts: snow pulls on no solid that it may leave.
  void predict() {
    const auto v = [&](std::size_t p, int count) {
      const Vec3<R> a = load_vector<R>(sums_.given, p, count) + load_vector<R>(sums_.pressed, p, count);
      return load_vector<R>(s_.v, p, count) + a * dt_;
    };
    const auto beside = [&](std::size_t p, int count) {
      return load<R>(sums_.inflow.column(0) + p, count) + load<R>(sums_.across.column(0) + p, count);
    };
    fill_quads(s_.count, sums_, v);
    find_across(s_, snow_, sums_, v);
    each_gradient(snow_, sums_, s_.count, sums_.walls, v, beside,
                  [&](std::size_t p, int count, const Mat3<R>& D) {
                    const Mat3<R> F = load_matrix<R>(s_.F_E, p, count);
                    const R G = load<R>(sums_.G.column(0) + p, count);
                    const R one = splat<R>(1);
                    const Sym3<R> old{F(0, 0) - one, F(1, 1) - one, F(2, 2) - one, F(0, 1), F(0, 2), F(1, 2)};
                    const Sym3<R> stress = sum_of(strained(D, F, R(G * dt_)), times(old, R(G * T(2))));
                    store_symmetric(sums_.s, p, stress, count);
                    const auto pulls = stress.xx + stress.yy + stress.zz > splat<R>(0);
                    const Vec3<R> walls = load_vector<R>(sums_.walls, p, count);
                    const Vec3<R> loose = load_vector<R>(sums_.loose, p, count);
                    store_vector(sums_.held, p, select(pulls, walls - loose, walls), count);
                    store(sums_.touch.column(0) + p, select(pulls, splat<R>(0), one), count);
                  });
  }

  // out = div s / rho, of the stress in `sums.s`.
  void accelerate(Vectors<T>& out) {
    fill_stress_rows(s_.count, sums_);
    each_divergence(snow_, sums_, s_.count, [&](std::size_t p, int count, const Vec3<R>& div) {
      store_vector(out, p, div * R(T(1) / load<R>(sums_.rho.column(0) + p, count)), count);
    });
    if (s_.has_water()) press_water(out);
  }

  // sums.s = dt^2 G (S[u] F + F S[u]).
  void change(const Vectors<T>& u) {
    const auto at = [&](std::size_t p, int count) { return load_vector<R>(u, p, count); };
    fill_quads(s_.count, sums_, at);
    find_across(s_, snow_, sums_, at);
    const auto beside = [&](std::size_t p, int count) {
      return R(load<R>(sums_.touch.column(0) + p, count) * load<R>(sums_.across.column(0) + p, count));
    };
    each_gradient(snow_, sums_, s_.count, sums_.held, at, beside,
                  [&](std::size_t p, int count, const Mat3<R>& D) {
                    const R factor = load<R>(sums_.G.column(0) + p, count) * (dt_ * dt_);
                    store_symmetric(sums_.s, p, strained(D, load_matrix<R>(s_.F_E, p, count), factor), count);
                  });
  }

  // out = M u = u - div (change of u) / rho.
  void apply(const Vectors<T>& u, Vectors<T>& out) {
    change(u);
    accelerate(out);
    set_packs(out, [&](std::size_t p, int count) {
      return load_vector<R>(u, p, count) - load_vector<R>(out, p, count);
    });
  }

 private:
  // Add what the trace of the stress does across the surface of the snow in water.
  void press_water(Vectors<T>& out) {
    press_.resize(s_.count + 64);
    each_row(s_.count, [&](std::size_t p) {
      const Sym3<T> s = symmetric_at(sums_.s, p);
      press_[p] = sums_.V.column(0)[p] * sums_.touch.column(0)[p] * (s.xx + s.yy + s.zz) * T(1.0 / 3);
    });
    each_row(s_.count, [&](std::size_t p) {
      const Vec3<T> more = trace_across(snow_, sums_, press_.data(), p) * (T(1) / sums_.rho.column(0)[p]);
      set_vector(out, p, vector_at(out, p) + more);
    });
  }

  const SphState<T>& s_;
  const SphPairs<T>& snow_;
  const T dt_;
  SphSums<T>& sums_;
  std::vector<T> press_;
};

// The blocks of three on the diagonal of M, which precondition it.
//
// What M does to one particle that alone has an acceleration u, at F = 1. The strain of particle k is then
// S = (u . b) / 3 + dev (u w^T + w u^T) / 2, of its own with b = -(around + held), w = -L around, of a neighbour's with
// b = -V_i grad W_ik, w = L_k b; and 2 G V |S|^2 in all of them is u . B u:
//
//   B = sum_k 2 G_k V_k (b b^T / 3 + |w|^2 / 2 + w w^T / 6),     M_ii = 1 + dt^2 B / m.
template <class T>
class ShearDiagonal {
 public:
  using R = Lanes<T>;

  // `sums.row` and `sums.quads` are used.
  ShearDiagonal(const SphState<T>& s, const SphPairs<T>& snow, T dt, SphSums<T>& sums) {
    inverse_.resize(s.count);
    each_pack<T>(s.count, [&](std::size_t p, int count) {  // L sqrt(2 G V), and the root
      const R root =
          sqrt(R(load<R>(sums.G.column(0) + p, count) * load<R>(sums.V.column(0) + p, count) * T(2)));
      const Mat3<R> L = load_matrix<R>(sums.L, p, count);
      for (int c = 0; c < 3; ++c) store_rows(L.column(c) * root, sums.row.data(), p, count, 3, c);
      store_rows(Vec3<R>{root, root, root}, sums.quads.data(), p, count);
    });
    each_row(s.count, [&](std::size_t p) {
      Four<T> columns[3]{};
      T square = 0;
      const auto add = [&](const Four<T>& b, const Four<T>& w) {
        for (int c = 0; c < 3; ++c)
          columns[c] = columns[c] + b * (b[c] * T(1.0 / 3)) + w * (w[c] * T(1.0 / 6));
        square += (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]) * T(0.5);
      };
      const auto of_row = [&](std::size_t k, const Vec3<T>& g, const Vec3<T>& b) {
        const Quartet<T>* L = sums.row.data() + 3 * k;
        const Four<T> scaled = four_at(Quartet<T>{b.x, b.y, b.z, T(0)}) * sums.quads[k].a;
        add(scaled, four_at(L[0]) * g.x + four_at(L[1]) * g.y + four_at(L[2]) * g.z);
      };
      const Vec3<T> around = vector_at(sums.around, p);
      of_row(p, around, around + vector_at(sums.held, p));
      const T V = sums.V.column(0)[p];
      for (std::uint32_t e = snow.begin[p]; e < snow.own_end(p); ++e) {
        const Vec3<T> g = snow.slope_at(e) * V;
        of_row(std::size_t(snow.row[e]), g, g);
      }
      const T scale = dt * dt / s.m.column(0)[p];
      const T isotropic = T(1) + scale * square;
      set_symmetric(inverse_, p,
                    {isotropic + scale * columns[0][0], isotropic + scale * columns[1][1],
                     isotropic + scale * columns[2][2], scale * columns[1][0], scale * columns[2][0],
                     scale * columns[2][1]});
    });
    each_pack<T>(s.count, [&](std::size_t p, int count) { invert(p, count); });
  }

  // z = M_ii^-1 r at each particle.
  void solve(const Vectors<T>& r, Vectors<T>& z) const {
    set_packs(z, [&](std::size_t p, int count) {
      return full(load_symmetric<R>(inverse_, p, count)) * load_vector<R>(r, p, count);
    });
  }

 private:
  void invert(std::size_t p, int count) {
    const Mat3<R> B = full(load_symmetric<R>(inverse_, p, count));
    const Vec3<R> a = cross(B.c1, B.c2), b = cross(B.c2, B.c0), c = cross(B.c0, B.c1);
    const R over = T(1) / dot(B.c0, a);
    store_symmetric(inverse_, p, times(Sym3<R>{a.x, b.y, c.z, a.y, a.z, b.z}, over), count);
  }

  Field<T, 6> inverse_;
};

}  // namespace detail

// With S[u] the symmetric part of D[u], F* = F + dt S[v + dt (given + pressed)] F and the stress s = G (F + F^T - 2), find
// the acceleration
//
//   a = div s(F* + dt^2 S[a] F) / rho,   that is   M a = b,
//   M a = a - dt^2 div G (S[a] F + F S[a]) / rho,   b = div s(F*) / rho.
//
// (F_next = F + dt S[v* + dt a] F, hence dt squared.) M is symmetric and positive: sum m u . M w is sum m u . w and dt^2 sum
// V G (S[u] F + F S[u]) : S[w]. The iteration starts from the acceleration of the last step. `sheared` becomes div s / rho
// with the stress at the end, which is left in `sums.s`: so what pairs give each other is opposite to rounding, however far
// the iteration went.
template <class T>
SolveReport solve_shear(const SphState<T>& s, const SphPairs<T>& snow, double dt, const SolveLimits& limits,
                        SphSums<T>& sums) {
  using R = Lanes<T>;
  const std::size_t n = s.count;
  detail::ShearSolve<T> shear(s, snow, T(dt), sums);
  Vectors<T> b, a;
  b.resize(n), a.resize(n);
  shear.predict();
  Field<T, 6> start;
  start.resize(n);
  each_pack<T>(n, [&](std::size_t p, int count) {
    store_symmetric(start, p, load_symmetric<R>(sums.s, p, count), count);
  });
  shear.accelerate(b);
  set_packs(a, [&](std::size_t p, int count) { return load_vector<R>(s.a_last, p, count); });
  const detail::ShearDiagonal<T> diagonal(s, snow, T(dt), sums);
  const SolveReport report = conjugate_gradients<T>(
      s.m, [&](const Vectors<T>& u, Vectors<T>& out) { shear.apply(u, out); },
      [&](const Vectors<T>& r, Vectors<T>& z) { diagonal.solve(r, z); }, b, a, limits);
  shear.change(a);
  each_pack<T>(n, [&](std::size_t p, int count) {
    const Sym3<R> end =
        detail::sum_of(load_symmetric<R>(start, p, count), load_symmetric<R>(sums.s, p, count));
    store_symmetric(sums.s, p, end, count);
  });
  shear.accelerate(sums.sheared);
  return report;
}

}  // namespace neve
