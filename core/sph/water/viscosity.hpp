// The viscosity of water, implicitly.
#pragma once

#include "sph/conjugate_gradients.hpp"

namespace neve::detail {

// The acceleration of pairs with water in them, along their line (Monaghan 2005), so that both momenta hold:
//
//   10 mu sum_j V_i V_j (u_ij . x_ij) / (|x_ij|^2 + 0.01 h^2) grad W_ij / m_i
template <class T>
class Viscosity {
 public:
  using R = Lanes<T>;
  Viscosity(const CubicKernel<T>& kernel, const SphState<T>& s, const SphPairs<T>& pairs, double dt,
            const SphSums<T>& sums)
      : s_(s), pairs_(pairs), soft_(T(0.01) * kernel.h * kernel.h), dt_(T(dt)), sums_(sums) {}

  // Leave in `dragged` the acceleration that the velocity v + dt (given + dragged) causes. As of shear, it is computed once
  // more from the solution, so that what pairs give each other is opposite to rounding.
  SolveReport solve(const SolveLimits& limits, Vectors<T>& dragged) const {
    set_packs(dragged, [](std::size_t, int) { return Vec3<R>{}; });
    if (!(s_.water.viscosity > 0)) return {};
    Vectors<T> a, b, v;
    for (Vectors<T>* each : {&a, &b, &v}) each->resize(s_.count);
    const auto fallen = [&](std::size_t p, int count) {
      return load_vector<R>(s_.v, p, count) + load_vector<R>(sums_.given, p, count) * dt_;
    };
    set_packs(v, fallen);
    accelerate(v, b);
    const SolveReport report = conjugate_gradients<T>(
        s_.m,
        [&](const Vectors<T>& u, Vectors<T>& out) {
          accelerate(u, out);
          set_packs(out, [&](std::size_t p, int count) {
            return load_vector<R>(u, p, count) - load_vector<R>(out, p, count) * dt_;
          });
        },
        [](const Vectors<T>& r, Vectors<T>& z) {
          set_packs(z, [&](std::size_t p, int count) { return load_vector<R>(r, p, count); });
        },
        b, a, limits);
    set_packs(v,
              [&](std::size_t p, int count) { return fallen(p, count) + load_vector<R>(a, p, count) * dt_; });
    accelerate(v, dragged);
    return report;
  }

 private:
  void accelerate(const Vectors<T>& u, Vectors<T>& out) const {
    each_row(s_.count, [&](std::size_t p) {
      const Vec3<T> x = vector_at(s_.x, p), here = vector_at(u, p);
      Vec3<T> sum{};
      for (std::uint32_t e = s_.is_water(p) ? pairs_.begin[p] : pairs_.split[p]; e < pairs_.begin[p + 1];
           ++e) {
        const auto j = std::size_t(pairs_.row[e]);
        const Vec3<T> d = x - vector_at(s_.x, j);
        const T along = dot(here - vector_at(u, j), d) / (dot(d, d) + soft_);
        sum = sum + pairs_.slope_at(e) * (sums_.V.column(0)[j] * along);
      }
      const T scale = T(10 * s_.water.viscosity) * sums_.V.column(0)[p] / s_.m.column(0)[p];
      set_vector(out, p, sum * scale);
    });
  }

  const SphState<T>& s_;
  const SphPairs<T>& pairs_;
  const T soft_, dt_;
  const SphSums<T>& sums_;
};

}  // namespace neve::detail
