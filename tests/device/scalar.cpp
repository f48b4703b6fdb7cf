// The physics over plain numbers, for test_scalar.py: what a device runs, where each particle is a number of its own.
#include "constitutive/principal.hpp"

namespace neve::probe {

// Decompose n matrices, row by row in F; U, sigma and V follow one another in `out`, 21 numbers a matrix.
template <class T>
void decompose(const T* F, int n, T* out) {
  for (int p = 0; p < n; ++p, F += 9, out += 21) {
    Mat3<T> f;
    for (int k = 0; k < 9; ++k) f(k / 3, k % 3) = F[k];
    const Svd3<T> svd = svd3(f);
    for (int k = 0; k < 9; ++k) out[k] = svd.U(k / 3, k % 3), out[12 + k] = svd.V(k / 3, k % 3);
    for (int k = 0; k < 3; ++k) out[9 + k] = svd.sigma[k];
  }
}

// Singular values as laws see them, of n matrices.
template <class T>
void stretches(const T* F, int n, T* out) {
  for (int p = 0; p < n; ++p, F += 9, out += 3) {
    Mat3<T> f;
    for (int k = 0; k < 9; ++k) f(k / 3, k % 3) = F[k];
    const Vec3<T> sigma = with_stretches(f, [](const auto& at) { return at.sigma; });
    for (int k = 0; k < 3; ++k) out[k] = sigma[k];
  }
}

// All that is asked of a pair of numbers, eleven answers.
template <class T>
void compare(T a, T b, T* out) {
  const auto less = a < b, zero = a == T(0);
  const bool asked[4] = {any(less), any(less | zero), any(less & zero), any(negated(less | zero))};
  for (int k = 0; k < 4; ++k) out[k] = asked[k];
  out[4] = select(less | zero, a, b);
  out[5] = min(a, b), out[6] = max(a, b), out[7] = abs(a), out[8] = clamp(a, T(-1), T(1));
  out[9] = max_lane(a), out[10] = splat<T>(b);
}

template <class T>
void functions(T a, T* out) {
  out[0] = exp(a), out[1] = expm1(a), out[2] = log1p(a), out[3] = sinh_positive(a),
  out[4] = asinh_positive(a);
  out[5] = sqrt(a), out[6] = rsqrt(a), out[7] = rough_rsqrt(a), out[8] = floor(a);
  out[9] = reciprocal(a);
}

}  // namespace neve::probe

using namespace neve::probe;
extern "C" {
void svd_float32(const float* F, int n, float* out) { decompose(F, n, out); }
void svd_float64(const double* F, int n, double* out) { decompose(F, n, out); }
void stretches_float32(const float* F, int n, float* out) { stretches(F, n, out); }
void stretches_float64(const double* F, int n, double* out) { stretches(F, n, out); }
void compare_float32(float a, float b, float* out) { compare(a, b, out); }
void compare_float64(double a, double b, double* out) { compare(a, b, out); }
void functions_float32(float a, float* out) { functions(a, out); }
void functions_float64(double a, double* out) { functions(a, out); }
}
