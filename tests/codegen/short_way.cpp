// For test_short_way.py: an elasticity that tells which way its response was computed. The short way, from invariants, gives the
// modulus 1; the long one, from principal strains, gives no numbers at all.
#include "constitutive/snow_plasticity.hpp"
#include "math/functions.hpp"

namespace neve::probe {

struct Telltale {
  template <class R>
  static Stress<R> small_response(const SmallStrain<R>&, R, R) {
    const R zero = splat<R>(0);
    return {{zero, zero, zero, zero, zero, zero}, splat<R>(1)};
  }
  template <class R>
  static Response<R> respond(const Vec3<R>&, R, R) {
    const R none = splat<R>(std::numeric_limits<scalar_t<R>>::quiet_NaN());
    return {none, {none, none, none}, none};
  }
};
using Law = SnowPlasticity<Telltale>;

template <class R>
Law::Parameters<R> thresholds(scalar_t<R> theta_c, scalar_t<R> theta_s) {
  const R one = splat<R>(1);
  return {one,
          one,
          one,
          splat<R>(theta_c),
          splat<R>(theta_s),
          splat<R>(scalar_t<R>(0.6)),
          splat<R>(scalar_t<R>(20))};
}

// Which of the lanes of a pack of matrices F, row by row, took the short way in the return map [0] and in the stress [1].
template <class T>
void ways(const T* F, T theta_c, T theta_s, int* map, int* stress) {
  using R = Lanes<T>;
  Mat3<R> f;
  for (int l = 0; l < width<R>; ++l) {
    for (int k = 0; k < 9; ++k) f(k / 3, k % 3)[l] = F[9 * l + k];
  }
  const auto q = thresholds<R>(theta_c, theta_s);
  const R one = splat<R>(1), mapped = Law::return_map(f, one, q).stress.modulus;
  const R stressed = Law::stress(f, one, q).modulus;
  for (int l = 0; l < width<R>; ++l) map[l] = mapped[l] == T(1), stress[l] = stressed[l] == T(1);
}

}  // namespace neve::probe

extern "C" {
int lanes_float32() { return neve::lane_count<float>; }
int lanes_float64() { return neve::lane_count<double>; }
void ways_float32(const float* F, float theta_c, float theta_s, int* map, int* stress) {
  neve::probe::ways(F, theta_c, theta_s, map, stress);
}
void ways_float64(const double* F, double theta_c, double theta_s, int* map, int* stress) {
  neve::probe::ways(F, theta_c, theta_s, map, stress);
}
}
