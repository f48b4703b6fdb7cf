// The pure mathematics on arrays, for tests and teaching: weights, SVD, constitutive law. Lane packs included: arrays
// go through the same packs as particles do.
#pragma once

#include <nanobind/stl/string.h>

#include "bind/arrays.hpp"
#include "bind/snow.hpp"
#include "constitutive/stomakhin2013.hpp"
#include "math/bspline.hpp"

namespace neve::bind {

template <class T>
Mat3<Lanes<T>> matrices(const T* rows, int count) {
  auto a = identity<Lanes<T>>();
  for (int l = 0; l < count; ++l) {
    for (int k = 0; k < 9; ++k) a(k / 3, k % 3)[l] = rows[9 * l + k];
  }
  return a;
}
template <class T>
void write_matrices(T* rows, const Mat3<Lanes<T>>& a, int count) {
  for (int l = 0; l < count; ++l) {
    for (int k = 0; k < 9; ++k) rows[9 * l + k] = a(k / 3, k % 3)[l];
  }
}

template <class T>
using Matrices = In<T, nb::shape<-1, 3, 3>>;
template <class T>
using Numbers = In<T, nb::shape<-1>>;

template <class T>
nb::tuple svd(const Matrices<T>& F) {
  const std::size_t n = F.shape(0);
  T *u, *s, *v;
  auto U = fresh<T>(u, {n, 3, 3});
  auto S = fresh<T>(s, {n, 3});
  auto V = fresh<T>(v, {n, 3, 3});
  constexpr std::size_t L = lane_count<T>;
  for (std::size_t p = 0; p < n; p += L) {
    const int count = static_cast<int>(std::min(L, n - p));
    const auto d = svd3(matrices<T>(F.data() + 9 * p, count));
    write_matrices<T>(u + 9 * p, d.U, count);
    write_matrices<T>(v + 9 * p, d.V, count);
    for (int l = 0; l < count; ++l) {
      for (int k = 0; k < 3; ++k)
        s[3 * (p + static_cast<std::size_t>(l)) + static_cast<std::size_t>(k)] = d.sigma[k][l];
    }
  }
  return nb::make_tuple(U, S, V);
}

template <class T, class S>
nb::tuple weights_of(const Numbers<T>& x) {
  const std::size_t n = x.shape(0), K = S::nodes;
  std::int32_t* base;
  T *w, *dw;
  auto B = fresh<std::int32_t>(base, {n});
  auto W = fresh<T>(w, {n, K});
  auto D = fresh<T>(dw, {n, K});
  for (std::size_t p = 0; p < n; ++p) {
    const T s = x.data()[p] - T(S::shift), b = std::floor(s);
    base[p] = static_cast<std::int32_t>(b);
    S::weights(s - b, w + K * p, dw + K * p);
  }
  return nb::make_tuple(B, W, D);
}

template <class T>
nb::tuple return_map_of(const Matrices<T>& F, const Numbers<T>& J_P, const Constants& constants) {
  using R = Lanes<T>;
  const std::size_t n = F.shape(0);
  if (J_P.shape(0) != n) throw nb::value_error("F and J_P differ in length");
  const auto q =
      Stomakhin2013::parameters<R>(snow_of("stomakhin2013", "snow", constants), splat<R>(1), splat<R>(1));
  T *f, *j, *t, *e;
  auto FE = fresh<T>(f, {n, 3, 3});
  auto JP = fresh<T>(j, {n});
  auto tau = fresh<T>(t, {n, 3, 3});
  auto psi = fresh<T>(e, {n});
  for (std::size_t p = 0; p < n; p += width<R>) {
    const int count = static_cast<int>(std::min<std::size_t>(width<R>, n - p));
    const auto mapped =
        Stomakhin2013::return_map(matrices<T>(F.data() + 9 * p, count), load<R>(J_P.data() + p, count), q);
    write_matrices<T>(f + 9 * p, mapped.F_E, count);
    write_matrices<T>(t + 9 * p, full(mapped.stress.tau), count);
    store(j + p, mapped.J_P, count);
    store(e + p, Stomakhin2013::energy(mapped.F_E, mapped.J_P, q), count);
  }
  return nb::make_tuple(FE, JP, tau, psi);
}

template <class T>
void bind_material_point(nb::module_& m) {
  m.attr("lanes") = lane_count<T>;
  m.def("svd", &svd<T>, nb::arg("F"), "Polar SVD of F (n, 3, 3): rotations U and V, singular values (n, 3).");
  m.def(
      "weights",
      [](const std::string& spline, const Numbers<T>& x) {
        if (spline == "cubic") return weights_of<T, Cubic>(x);
        if (spline == "quadratic") return weights_of<T, Quadratic>(x);
        throw nb::value_error("spline: 'quadratic' or 'cubic'");
      },
      nb::arg("spline"), nb::arg("x"), "First node (n,), weights and derivatives (n, K) at x (n,) in cells.");
  m.def("stomakhin2013", &return_map_of<T>, nb::arg("F_trial"), nb::arg("J_P"), nb::arg("constants"),
        "Return map: F_E (n, 3, 3), J_P (n,), Kirchhoff stress tau (n, 3, 3) [Pa], energy psi (n,) [J/m3].");
}

}  // namespace neve::bind
