// A local energy of snow that flows, learned from its return map (after Li et al. 2022, "PlasticityNet", from memory):
//
//   Psi(F; F0) = E s^2 N(ln sigma(F)) + C : F + r/2 |F - F0|^2
//
// N is a small network of softplus functions of the principal logarithmic strains, which knows the strains at F0 and the
// snow's constants as well (`src/neve/learned/network.py` has its equations); C makes the force at F0 that of the return map,
// exactly. E is the stiffness, s a unit of strain (learned_units.hpp). All derivatives are continuous.
#pragma once

#include "constitutive/tangent.hpp"
#include "cpu/implicit/learned_units.hpp"
#include "cpu/implicit/products.hpp"

namespace neve {

inline constexpr int most_hidden = 64, context_of_strains = 6;
inline constexpr double deviator_round = 0.05;  // deviator below which its size is rounded off, in units

// The weights of a network: a, b (steps), W (hidden, steps + 2), V (hidden, context), w, d (hidden), q (2).
struct LearnedNet {
  int steps = 0, hidden = 0, told = 0;
  std::vector<double> a, b, W, V, w, d, q;
  double regularity = 0;  // r over the stiffness
  const double* row(int h) const { return &W[std::size_t(h * (steps + 2))]; }
  int context() const { return context_of_strains + told; }
};

// Where an energy is expanded: strains and plastic volume there, C, and r.
template <class R>
struct Expansion {
  Vec3<R> e0;
  R J_P;
  Mat3<R> C;
  R r;
};

template <class R, class M>
Expansion<R> select(const M& mask, const Expansion<R>& a, const Expansion<R>& b) {
  return {select(mask, a.e0, b.e0), select(mask, a.J_P, b.J_P), select(mask, a.C, b.C),
          select(mask, a.r, b.r)};
}

// What an energy makes of F: P [Pa], and its derivative in principal axes of F = U diag(sigma) V^T.
template <class R>
struct LearnedResponse {
  Mat3<R> P;
  Tangent<R> tangent;
};
template <class R, class M>
LearnedResponse<R> select(const M& mask, const LearnedResponse<R>& a, const LearnedResponse<R>& b) {
  return {select(mask, a.P, b.P), select(mask, a.tangent, b.tangent)};
}

namespace detail {

// dN/du of a pack, and its second derivatives.
template <class R>
struct LearnedStress {
  Vec3<R> T;
  Sym3<R> slope;
};

// What the hidden layer is told beside the steps: where the energy is expanded, the snow, the trace and size of the strain.
template <class R>
void begin_hidden(const LearnedNet& net, const LearnedUnits<R>& units, const Vec3<R>& u0, const R& trace,
                  const R& size, R* H) {
  using T = scalar_t<R>;
  R y[context_of_strains + most_told];
  for (int i = 0; i < 3; ++i) {
    y[i] = u0[i] / (T(1) + abs(u0[i]));
    y[3 + i] = u0[i] / (T(6) + abs(u0[i]));
  }
  const int context = net.context();
  for (int i = 0; i < net.told; ++i) y[context_of_strains + i] = units.told[i];
  for (int h = 0; h < net.hidden; ++h) {
    const double *W = net.row(h), *V = &net.V[std::size_t(h * context)];
    R sum = splat<R>(T(net.d[std::size_t(h)])) + trace * T(W[net.steps]) + size * T(W[net.steps + 1]);
    for (int c = 0; c < context; ++c) sum = sum + y[c] * T(V[c]);
    H[h] = sum;
  }
}

// Steps: their sums over the axes go to the hidden layer, their slopes s are kept.
template <class R>
void add_steps(const LearnedNet& net, const Vec3<R>& u, Vec3<R>* s, R* H) {
  using T = scalar_t<R>;
  const R one = splat<R>(1), zero = splat<R>(0);
  for (int k = 0; k < net.steps; ++k) {
    const T a = T(net.a[std::size_t(k)]), b = T(net.b[std::size_t(k)]);
    R sum = zero;
    for (int i = 0; i < 3; ++i) {
      const R x = u[i] * a + b, small = exp(R(-abs(x))), over = one / (one + small);
      sum = sum + (max(x, zero) + log1p(small));
      s[k][i] = select(x > zero, over, R(small * over));
    }
    for (int h = 0; h < net.hidden; ++h) H[h] = H[h] + sum * T(net.row(h)[k]);
  }
}

template <class R>
void add_square(Sym3<R>& to, const Vec3<R>& g, const R& a) {
  to.xx += a * g.x * g.x, to.yy += a * g.y * g.y, to.zz += a * g.z * g.z;
  to.xy += a * g.x * g.y, to.xz += a * g.x * g.z, to.yz += a * g.y * g.z;
}

// `with_slope`: whether the second derivatives are wanted.
template <class R>
LearnedStress<R> learned_stress(const LearnedNet& net, const LearnedUnits<R>& units, const Vec3<R>& u,
                                const Vec3<R>& u0, bool with_slope) {
  using T = scalar_t<R>;
  const int K = net.steps;
  const R one = splat<R>(1), zero = splat<R>(0), trace = u.x + u.y + u.z, third = trace * T(1.0 / 3);
  const Vec3<R> dev{u.x - third, u.y - third, u.z - third};
  const R size = sqrt(dot(dev, dev) + T(deviator_round * deviator_round));
  const Vec3<R> way = dev * (one / size);
  R H[most_hidden], Q[most_hidden + 2];
  Vec3<R> s[most_hidden];
  begin_hidden(net, units, u0, trace, size, H);
  add_steps(net, u, s, H);
  const T q0 = T(net.q[0]), q1 = T(net.q[1]);
  const R own = splat<R>(q0 + q1), pair = splat<R>(q0);
  LearnedStress<R> out{u * q1 + Vec3<R>{trace, trace, trace} * q0, {own, own, own, pair, pair, pair}};
  for (int k = 0; k < K + 2; ++k) Q[k] = zero;
  for (int h = 0; h < net.hidden; ++h) {
    const double* W = net.row(h);
    const R small = exp(R(-abs(H[h]))), over = one / (one + small);
    const R S = select(H[h] > zero, over, R(small * over)), p = S * T(net.w[std::size_t(h)]);
    for (int k = 0; k < K + 2; ++k) Q[k] = Q[k] + p * T(W[k]);
    if (!with_slope) continue;
    const R even = splat<R>(T(W[K]));
    Vec3<R> g = Vec3<R>{even, even, even} + way * T(W[K + 1]);
    for (int k = 0; k < K; ++k) g = g + s[k] * T(W[k] * net.a[std::size_t(k)]);
    add_square(out.slope, g, R(p * (one - S)));
  }
  const R turn = Q[K + 1] / size, less = turn * T(-1.0 / 3);
  out.T = out.T + Vec3<R>{Q[K], Q[K], Q[K]} + way * Q[K + 1];
  add_square(out.slope, way, R(-turn));
  Sym3<R>& slope = out.slope;
  slope.xx += turn + less, slope.yy += turn + less, slope.zz += turn + less;
  slope.xy += less, slope.xz += less, slope.yz += less;
  for (int k = 0; k < K; ++k) {
    const T a = T(net.a[std::size_t(k)]);
    const R Qa = Q[k] * a, bend = Qa * a;
    out.T = out.T + s[k] * Qa;
    slope.xx += bend * s[k].x * (one - s[k].x), slope.yy += bend * s[k].y * (one - s[k].y);
    slope.zz += bend * s[k].z * (one - s[k].z);
  }
  return out;
}

// The network's part alone: P and its derivative, if that is wanted.
template <class R>
LearnedResponse<R> network_response(const LearnedNet& net, const LearnedUnits<R>& units, const Vec3<R>& e0,
                                    const Svd3<R>& at, bool with_tangent) {
  using T = scalar_t<R>;
  const R inverse = splat<R>(1) / units.strain, scale = units.stiffness * units.strain;
  const auto in_units = [&](const Vec3<R>& e) {
    return with_deviator(Vec3<R>{(e.x - units.origin) * inverse, (e.y - units.origin) * inverse,
                                 (e.z - units.origin) * inverse},
                         units.deviator);
  };
  const Vec3<R> e = HenckyElasticity::log_strain(at.strain);
  auto n = learned_stress(net, units, in_units(e), in_units(e0), with_tangent);
  n.T = with_deviator(n.T, units.deviator), n.slope = with_deviator(n.slope, units.deviator);
  const R least = splat<R>(T(least_stretch)), one = splat<R>(1);
  const Vec3<R> s{max(at.sigma.x, least), max(at.sigma.y, least), max(at.sigma.z, least)};
  const Vec3<R> r{one / s.x, one / s.y, one / s.z}, tau = n.T * scale;
  const Vec3<R> g{tau.x * r.x, tau.y * r.y, tau.z * r.z};
  const R E = units.stiffness;
  LearnedResponse<R> out;
  Tangent<R>& t = out.tangent;
  t.block = {(E * n.slope.xx - tau.x) * r.x * r.x, (E * n.slope.yy - tau.y) * r.y * r.y,
             (E * n.slope.zz - tau.z) * r.z * r.z, E * n.slope.xy * r.x * r.y,
             E * n.slope.xz * r.x * r.z,           E * n.slope.yz * r.y * r.z};
  const R own[3] = {t.block.xx, t.block.yy, t.block.zz}, other[3] = {t.block.yz, t.block.xz, t.block.xy};
  const R near = units.strain * (std::is_same_v<T, float> ? T(2e-2) : T(1e-4));
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const R apart = at.strain[i] - at.strain[j];
    const auto equal = abs(apart) < near;
    t.m[k] =
        select(equal, R(T(0.5) * (own[i] + own[j]) - other[k]), R((g[i] - g[j]) / select(equal, one, apart)));
    t.p[k] = (g[i] + g[j]) / max(R(at.sigma[i] + at.sigma[j]), least);
  }
  out.P = times_transposed(Mat3<R>{at.U.c0 * g.x, at.U.c1 * g.y, at.U.c2 * g.z}, at.V);
  return out;
}

}  // namespace detail

// Expand around F0, which a return map makes `end` of.
template <class Law, class R>
Expansion<R> expand(const LearnedNet& net, Law law, const typename Law::template Parameters<R>& q,
                    const Mat3<R>& F0, const R& J_P, const Sym3<R>& tau, const Mat3<R>& inverse_transposed) {
  using T = scalar_t<R>;
  const Svd3<R> at = svd3(F0);
  const Vec3<R> e0 = HenckyElasticity::log_strain(at.strain);
  const auto units = learned_units(law, q, J_P, e0);
  Expansion<R> out{e0, J_P, {}, units.stiffness * T(net.regularity)};
  const Mat3<R> own = detail::network_response(net, units, out.e0, at, false).P,
                G = full(tau) * inverse_transposed;
  for (int j = 0; j < 3; ++j) out.C.column(j) = G.column(j) - own.column(j) - F0.column(j) * out.r;
  return out;
}

// P and its derivative at F, if that is wanted.
template <class Law, class R>
LearnedResponse<R> respond(const LearnedNet& net, Law law, const typename Law::template Parameters<R>& q,
                           const Mat3<R>& F, const Svd3<R>& at, const Expansion<R>& from, bool with_tangent) {
  const auto units = learned_units(law, q, from.J_P, from.e0);
  auto out = detail::network_response(net, units, from.e0, at, with_tangent);
  for (int j = 0; j < 3; ++j) out.P.column(j) = out.P.column(j) + from.C.column(j) + F.column(j) * from.r;
  Sym3<R>& b = out.tangent.block;
  b.xx += from.r, b.yy += from.r, b.zz += from.r;
  for (int k = 0; k < 3; ++k) out.tangent.m[k] += from.r, out.tangent.p[k] += from.r;
  return out;
}

}  // namespace neve
