// Snow that flows in an implicit step: its stress at the end, and how that changes with the deformation.
//
// A step deforms a particle to F, and the return map says which tau(F) it bears then. In principal stretches sigma of F its
// first Piola-Kirchhoff stress is g_k = tau_k / sigma_k, and dg_i / dsigma_j is found by central differences of the return
// map, which every law has. It is not symmetric where flow is not associated; its symmetric part is what is taken.
#pragma once

#include "cpu/fields.hpp"
#include "cpu/material.hpp"

namespace neve {

namespace detail {

// What the return map makes of F, without ice.
template <class T>
[[gnu::noinline]] Mapped<Lanes<T>> flowed_snow(const Model<T>& model, const State<T>& state, std::size_t p,
                                               int count, const Mat3<Lanes<T>>& F, const Lanes<T>& J_P) {
  return return_map(model, state, p, count, only_snow(model, state, p, static_cast<std::size_t>(count)), F,
                    J_P);
}

// g at the principal strains e of a map from F to tau.
template <class R, class Map>
Vec3<R> principal_forces(const Vec3<R>& e, Map&& map) {
  const R one = splat<R>(1), zero = splat<R>(0);
  const Vec3<R> s{one + e.x, one + e.y, one + e.z};
  const Mat3<R> F{{s.x, zero, zero}, {zero, s.y, zero}, {zero, zero, s.z}};
  const Sym3<R> tau = map(F);
  return {tau.xx / s.x, tau.yy / s.y, tau.zz / s.z};
}

// The derivative of what flows by a map from F to tau, symmetric part.
template <class R, class Map>
Tangent<R> flow_tangent(const Vec3<R>& e, Map&& map) {
  using T = scalar_t<R>;
  constexpr T least = std::is_same_v<T, float> ? T(2e-5) : T(1e-7);
  const R one = splat<R>(1), half = splat<R>(T(0.5));
  const R size = max(max(abs(e.x), abs(e.y)), abs(e.z));
  const R h = clamp(R(size * T(0.02)), splat<R>(least), splat<R>(T(1e-3))), over = half / h;
  Mat3<R> dg;  // column j: d g / d sigma_j
  for (int j = 0; j < 3; ++j) {
    Vec3<R> up = e, down = e;
    up[j] = up[j] + h, down[j] = down[j] - h;
    dg.column(j) = (principal_forces(up, map) - principal_forces(down, map)) * over;
  }
  const Vec3<R> g = principal_forces(e, map);
  Tangent<R> t{{dg.c0.x, dg.c1.y, dg.c2.z, half * (dg.c0.y + dg.c1.x), half * (dg.c0.z + dg.c2.x),
                half * (dg.c1.z + dg.c2.y)},
               {},
               {}};
  const R own[3] = {t.block.xx, t.block.yy, t.block.zz}, other[3] = {t.block.yz, t.block.xz, t.block.xy};
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const R apart = e[i] - e[j], sum = max(R(T(2) + e[i] + e[j]), splat<R>(T(least_stretch)));
    const auto equal = abs(apart) < h;
    t.m[k] =
        select(equal, R(half * (own[i] + own[j]) - other[k]), R((g[i] - g[j]) / select(equal, one, apart)));
    t.p[k] = (g[i] + g[j]) / sum;
  }
  return t;
}

// a (1 - share) + b share.
template <class R>
Tangent<R> blended(const Tangent<R>& a, const Tangent<R>& b, scalar_t<R> share) {
  const scalar_t<R> rest = scalar_t<R>(1) - share;
  const auto mean = [&](const R& x, const R& y) { return R(x * rest + y * share); };
  const Sym3<R>&s = a.block, &t = b.block;
  return {{mean(s.xx, t.xx), mean(s.yy, t.yy), mean(s.zz, t.zz), mean(s.xy, t.xy), mean(s.xz, t.xz),
           mean(s.yz, t.yz)},
          a.m * rest + b.m * share,
          a.p * rest + b.p * share};
}

// The lanes that flow: those whose elastic deformation is not F.
template <class R>
auto flows(const Mat3<R>& F, const R& J_P, const Mapped<R>& end) {
  auto out = end.J_P != J_P;
  for (int k = 0; k < 3; ++k) {
    const Vec3<R>&a = F.column(k), &b = end.F_E.column(k);
    out = out | (a.x != b.x) | (a.y != b.y) | (a.z != b.z);
  }
  return out;
}

}  // namespace detail

// The stress of a pack that a step deforms to F, flow and ice included.
template <class T>
Stress<Lanes<T>> flowed_stress(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                               const Mat3<Lanes<T>>& F, const Lanes<T>& J_P) {
  Stress<Lanes<T>> out = detail::flowed_snow(model, state, p, count, F, J_P).stress;
  const Lanes<T> J = determinant(F) * J_P;
  if (any(near_ice(detail::ice_room(model, state, p, count, J))))
    detail::add_ice(model, state, p, count, J, T(0), out);
  return out;
}

}  // namespace neve
