// The stiffness of particles, as an implicit step uses it: H u = sum_p V0 (dP : (grad u F_E)) F_E^T g for the velocity u.
#pragma once

#include <array>

#include "cpu/implicit/learned_fields.hpp"

namespace neve {

namespace detail {

// Second derivatives of the energy of a pack whose F has the principal strains `strain`.
template <class T>
Tangent<Lanes<T>> elastic_tangent(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                                  const Mat3<Lanes<T>>& F, const Vec3<Lanes<T>>& strain,
                                  const Lanes<T>& J_P) {
  using Out = Tangent<Lanes<T>>;
  return by_law<Out>(model, state, p, count, F, [&](auto law, const auto& q, const auto&) -> Out {
    return decltype(law)::tangent(strain, J_P, q);
  });
}

// The same, of what the law makes of snow that flows; `elastic` is the share of the elastic derivatives there.
template <class T>
Tangent<Lanes<T>> law_tangent(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                              const Mat3<Lanes<T>>& F, const Vec3<Lanes<T>>& strain, const Lanes<T>& J_P,
                              double elastic) {
  using R = Lanes<T>;
  const Tangent<R> t = elastic_tangent(model, state, p, count, F, strain, J_P);
  if (!(elastic < 1)) return t;
  const auto flowing = first_lanes<R>(count) & flows(F, J_P, flowed_snow(model, state, p, count, F, J_P));
  if (!any(flowing)) return t;
  const auto map = [&](const Mat3<R>& at) { return flowed_snow(model, state, p, count, at, J_P).stress.tau; };
  return select(flowing, blended(flow_tangent(strain, map), t, T(elastic)), t);
}

// U K Y^T, K what the tangent makes of U^T G Y.
template <class R>
NEVE_INLINE Mat3<R> derivative(const Tangent<R>& t, const Mat3<R>& U, const Mat3<R>& Y, const Mat3<R>& G) {
  const Mat3<R> GY = G * Y;
  const Mat3<R> D{transposed_times(U, GY.c0), transposed_times(U, GY.c1), transposed_times(U, GY.c2)};
  return times_transposed(U * contracted(t, D), Y);
}

// Add what ice does to snow whose F has the principal stretches `sigma`.
template <class T>
void add_ice_tangent(const Model<T>& model, const State<T>& state, std::size_t p, int count,
                     const Vec3<Lanes<T>>& sigma, const Lanes<T>& J_P, Tangent<Lanes<T>>& out) {
  using R = Lanes<T>;
  const R J_E = sigma.x * sigma.y * sigma.z, J = J_E * J_P;
  if (!any(near_ice(ice_room(model, state, p, count, J)))) return;
  const PackIce<T> pack(model, state, p, count);
  const R z = max(pack.ice.beyond(J), splat<R>(0)), here = select(pack.mark > R{}, splat<R>(1), R{});
  const R pressure = here * pack.ice.pressure(z), slope = here * pack.ice.slope(z),
          inverse = splat<R>(1) / J_E;
  add_volume(out, sigma, R(-pressure * inverse), R((pressure + slope) * inverse * inverse));
}

}  // namespace detail

// What the product needs of each particle: with F = U diag(sigma) V^T and Y = F_E V, D = U^T G Y and the matrix to scatter is
// U K Y^T. Stiffnesses have all factors in them, so that they are masses [kg].
template <class T>
class Tangents {
  using R = Lanes<T>;

 public:
  void resize(std::size_t n) {
    if (n > coefficients_.size()) U_.resize(n), Y_.resize(n), coefficients_.resize(n);
  }

  // Of a pack that a step deforms from F_E to F = f F_E; `factor` is beta dt^2 scale^2. `elastic`: the share of the
  // elastic derivatives where snow flows; 1 leaves flow out. `learned`: what takes the place of laws and flow, if any does.
  void set(const Model<T>& model, const State<T>& state, std::size_t p, int count, const Mat3<R>& F,
           const Mat3<R>& F_E, const R& J_P, double factor, bool project, double elastic,
           const LearnedEnergies<T>* learned) {
    const Mat3<R> quieted = detail::quiet(F, first_lanes<R>(count));
    const Svd3<R> at = svd3(quieted);
    Tangent<R> t = learned ? learned->respond(model, state, p, count, quieted, at, true).tangent
                           : detail::law_tangent(model, state, p, count, quieted, at.strain, J_P, elastic);
    detail::add_ice_tangent(model, state, p, count, at.sigma, J_P, t);
    if (project) t = projected(t);
    t = times(t, R(load<R>(state.V0.column(0) + p, count) * T(factor)));
    store_matrix(U_, p, at.U, count);
    store_matrix(Y_, p, F_E * at.V, count);
    const R* entry[12] = {&t.block.xx, &t.block.yy, &t.block.zz, &t.block.xy, &t.block.xz, &t.block.yz,
                          &t.m.x,      &t.m.y,      &t.m.z,      &t.p.x,      &t.p.y,      &t.p.z};
    for (int k = 0; k < 12; ++k) store(coefficients_.column(k) + p, *entry[k], count);
  }

  // S_a of the axes a = x, y, z, as numbers xx yy zz xy xz yz: e_a . (the matrix for e_a g^T) g = g^T S_a g.
  std::array<Vec3<R>, 6> diagonal_forms(std::size_t p, int count) const {
    const Mat3<R> U = load_matrix<R>(U_, p, count), Y = load_matrix<R>(Y_, p, count);
    const auto number = [&](int k) { return load<R>(coefficients_.column(k) + p, count); };
    const R half = splat<R>(T(0.5));
    R even[3], odd[3];  // (m + p) / 2, (m - p) / 2
    for (int k = 0; k < 3; ++k) {
      const R m = number(6 + k), q = number(9 + k);
      even[k] = half * (m + q), odd[k] = half * (m - q);
    }
    std::array<Vec3<R>, 6> out;
    for (int a = 0; a < 3; ++a) {
      const R x = U.c0[a], y = U.c1[a], z = U.c2[a], xx = x * x, yy = y * y, zz = z * z;
      const Sym3<R> form{number(0) * xx + even[2] * yy + even[1] * zz,
                         number(1) * yy + even[2] * xx + even[0] * zz,
                         number(2) * zz + even[1] * xx + even[0] * yy,
                         x * y * (number(3) + odd[2]),
                         x * z * (number(4) + odd[1]),
                         y * z * (number(5) + odd[0])};
      const Mat3<R> S = detail::times_transposed(Y * full(form), Y);
      const R entry[6] = {S.c0.x, S.c1.y, S.c2.z, S.c1.x, S.c2.x, S.c2.y};
      for (std::size_t k = 0; k < 6; ++k) out[k][a] = entry[k];
    }
    return out;
  }

  // The matrix that a pack scatters for the gradient G.
  NEVE_INLINE Mat3<R> times_gradient(std::size_t p, int count, const Mat3<R>& G) const {
    const Mat3<R> U = load_matrix<R>(U_, p, count), Y = load_matrix<R>(Y_, p, count);
    const auto number = [&](int k) { return load<R>(coefficients_.column(k) + p, count); };
    const Tangent<R> t{{number(0), number(1), number(2), number(3), number(4), number(5)},
                       {number(6), number(7), number(8)},
                       {number(9), number(10), number(11)}};
    return detail::derivative(t, U, Y, G);
  }

 private:
  Field<T, 9> U_, Y_;
  Field<T, 12> coefficients_;
};

}  // namespace neve
