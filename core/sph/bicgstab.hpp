// BiCGSTAB (van der Vorst 1992) on vectors of the particles, without a matrix.
#pragma once

#include "sph/pressure.hpp"

namespace neve {

// Three numbers of each particle.
template <class T>
using Vectors = Field<T, 3>;

template <class T>
double product(const Vectors<T>& a, const Vectors<T>& b) {
  return sum_rows(a.size(), [&](std::size_t p) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += double(a.column(k)[p]) * double(b.column(k)[p]);
    return sum;
  });
}

// to = f(p, k) at each particle p and axis k.
template <class T, class F>
void each_number(Vectors<T>& to, F&& f) {
  each_row(to.size(), [&](std::size_t p) {
    for (int k = 0; k < 3; ++k) to.column(k)[p] = f(p, k);
  });
}

// Solve M x = b from x = 0, apply(u, out) giving out = M u, until |b - M x| <= tolerance |b|. b becomes b - M x, as the
// iteration knows it.
template <class T, class F>
SolveReport bicgstab(F&& apply, Vectors<T>& b, Vectors<T>& x, const SolveLimits& limits) {
  const std::size_t n = b.size();
  Vectors<T>& r = b;
  Vectors<T> first, d, Md, Mr;
  for (Vectors<T>* each : {&first, &d, &Md, &Mr}) each->resize(n);
  each_number(x, [](std::size_t, int) { return T(0); });
  each_number(first, [&](std::size_t p, int k) { return r.column(k)[p]; });
  each_number(d, [&](std::size_t p, int k) { return r.column(k)[p]; });
  double rho = product(first, r), size = std::sqrt(product(r, r));
  const double whole = size;
  SolveReport report;
  const auto done = [&] {
    report.residual = whole > 0 ? size / whole : size;
    report.converged = report.residual <= limits.tolerance;
    return report.converged || report.iterations >= limits.most || !std::isfinite(size);
  };
  while (!done()) {
    apply(d, Md);
    const double along = product(first, Md);
    if (along == 0) break;
    const T alpha = T(rho / along);
    each_number(r, [&](std::size_t p, int k) { return r.column(k)[p] - alpha * Md.column(k)[p]; });
    apply(r, Mr);
    const double square = product(Mr, Mr);
    const T omega = square > 0 ? T(product(Mr, r) / square) : T(0);
    each_number(x, [&](std::size_t p, int k) {
      return x.column(k)[p] + alpha * d.column(k)[p] + omega * r.column(k)[p];
    });
    each_number(r, [&](std::size_t p, int k) { return r.column(k)[p] - omega * Mr.column(k)[p]; });
    const double next = product(first, r);
    size = std::sqrt(product(r, r));
    ++report.iterations;
    if (omega == T(0) || rho == 0 || std::abs(next) < 1e-12 * whole * size) {  // begin anew from here
      each_number(first, [&](std::size_t p, int k) { return r.column(k)[p]; });
      each_number(d, [&](std::size_t p, int k) { return r.column(k)[p]; });
      rho = product(first, r);
      continue;
    }
    const T beta = T(next / rho) * (alpha / omega);
    rho = next;
    each_number(d, [&](std::size_t p, int k) {
      return r.column(k)[p] + beta * (d.column(k)[p] - omega * Md.column(k)[p]);
    });
  }
  return report;
}

}  // namespace neve
