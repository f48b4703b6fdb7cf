// Conjugate gradients (Hestenes and Stiefel 1952) on vectors of the particles, without a matrix.
#pragma once

#include "sph/pressure.hpp"

namespace neve {

// Three numbers of each particle.
template <class T>
using Vectors = Field<T, 3>;

// sum m a . b.
template <class T>
double product(const Field<T, 1>& m, const Vectors<T>& a, const Vectors<T>& b) {
  return sum_rows(a.size(), [&](std::size_t p) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += double(a.column(k)[p]) * double(b.column(k)[p]);
    return sum * double(m.column(0)[p]);
  });
}

// Call f(p, count) as each_pack does, and set the vectors `to` to what it returns.
template <class T, class F>
void set_packs(Vectors<T>& to, F&& f) {
  each_pack<T>(to.size(), [&](std::size_t p, int count) { store_vector(to, p, f(p, count), count); });
}

// Solve M x = b from x as it is, for a matrix that is symmetric and positive in the product sum m a . b, until |b - M x| <=
// tolerance |b|. apply(u, out): out = M u; precondition(r, z): z is about M^-1 r, by a matrix that is symmetric and positive
// likewise. b becomes b - M x, as the iteration knows it.
template <class T, class F, class P>
SolveReport conjugate_gradients(const Field<T, 1>& m, F&& apply, P&& precondition, Vectors<T>& b,
                                Vectors<T>& x, const SolveLimits& limits) {
  using R = Lanes<T>;
  const auto at = [](const Vectors<T>& a, std::size_t p, int count) { return load_vector<R>(a, p, count); };
  Vectors<T>& r = b;
  Vectors<T> d, Md, z;
  for (Vectors<T>* each : {&d, &Md, &z}) each->resize(b.size());
  const double whole = std::sqrt(product(m, b, b));
  SolveReport report;
  double size = whole;
  const auto done = [&] {
    report.residual = whole > 0 ? size / whole : size;
    report.converged = report.residual <= limits.tolerance;
    return report.converged || report.iterations >= limits.most || !std::isfinite(size);
  };
  if (whole == 0) {
    set_packs(x, [&](std::size_t, int) { return Vec3<R>{}; });
    return report;
  }
  apply(x, Md);
  set_packs(r, [&](std::size_t p, int count) { return at(r, p, count) - at(Md, p, count); });
  size = std::sqrt(product(m, r, r));
  double before = 0;
  while (!done()) {
    precondition(r, z);
    const double along = product(m, r, z);
    const T beta = T(before > 0 ? along / before : 0);
    before = along;
    set_packs(d, [&](std::size_t p, int count) { return at(z, p, count) + at(d, p, count) * beta; });
    apply(d, Md);
    const double curvature = product(m, d, Md);
    if (!(curvature > 0)) break;  // rounding
    const T alpha = T(along / curvature);
    set_packs(x, [&](std::size_t p, int count) { return at(x, p, count) + at(d, p, count) * alpha; });
    set_packs(r, [&](std::size_t p, int count) { return at(r, p, count) - at(Md, p, count) * alpha; });
    size = std::sqrt(product(m, r, r));
    ++report.iterations;
  }
  return report;
}

}  // namespace neve
