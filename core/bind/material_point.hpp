// The pure mathematics on arrays, for tests and teaching: weights, SVD, constitutive law. Lane packs included: arrays
// go through the same packs as particles do.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>

#include "bind/arrays.hpp"
#include "bind/snow.hpp"
#include "cpu/material.hpp"
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
using Reals = In<T, nb::shape<-1>>;

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

template <class T>
nb::tuple isotropic_function_of(const Matrices<T>& F, const In<T, nb::shape<-1, 3>>& y) {
  const std::size_t n = F.shape(0);
  if (y.shape(0) != n) throw nb::value_error("F and y differ in length");
  T *e, *out;
  auto E = fresh<T>(e, {n, 3});
  auto Y = fresh<T>(out, {n, 3, 3});
  constexpr std::size_t L = lane_count<T>;
  for (std::size_t p = 0; p < n; p += L) {
    const int count = static_cast<int>(std::min(L, n - p));
    const auto spectrum = spectrum3(strain_of(matrices<T>(F.data() + 9 * p, count)));
    Vec3<Lanes<T>> at{};
    for (int l = 0; l < count; ++l) {
      for (int k = 0; k < 3; ++k) {
        const std::size_t place = 3 * (p + static_cast<std::size_t>(l)) + static_cast<std::size_t>(k);
        at[k][l] = y.data()[place];
        e[place] = spectrum.e[k][l];
      }
    }
    write_matrices<T>(out + 9 * p, full(isotropic_function(spectrum, at)), count);
  }
  return nb::make_tuple(E, Y);
}

template <class T, class S>
nb::tuple weights_of(const Reals<T>& x) {
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

// Pack by pack: the return map of one snow, and the energy of the new state.
template <class T>
nb::tuple law_of(const std::string& name, const std::string& plasticity, const Numbers& constants,
                 const Matrices<T>& F, const Reals<T>& J_P, const std::optional<Reals<T>>& strength) {
  using R = Lanes<T>;
  const std::size_t n = F.shape(0);
  if (J_P.shape(0) != n || (strength && strength->shape(0) != n))
    throw nb::value_error("F_trial, J_P and strength differ in length");
  const Snow snow = snow_of(name, plasticity, constants);
  T *f, *j, *t, *e, *c;
  auto FE = fresh<T>(f, {n, 3, 3});
  auto JP = fresh<T>(j, {n});
  auto tau = fresh<T>(t, {n, 3, 3});
  auto psi = fresh<T>(e, {n});
  auto modulus = fresh<T>(c, {n});
  const R one = splat<R>(1);
  with_law(snow.law, [&](auto law) {
    using L = decltype(law);
    for (std::size_t p = 0; p < n; p += width<R>) {
      const int count = static_cast<int>(std::min<std::size_t>(width<R>, n - p));
      const auto here = first_lanes<R>(count);
      const R given = strength ? load<R>(strength->data() + p, count) : one;
      const R J = load<R>(J_P.data() + p, count);
      const auto q = L::template parameters<R>(snow, one, select(here, given, one));
      const auto mapped = L::return_map(matrices<T>(F.data() + 9 * p, count), select(here, J, one), q);
      write_matrices<T>(f + 9 * p, mapped.F_E, count);
      write_matrices<T>(t + 9 * p, full(mapped.stress.tau), count);
      store(j + p, mapped.J_P, count);
      store(e + p, L::energy(mapped.F_E, mapped.J_P, q), count);
      store(c + p, mapped.stress.modulus, count);
    }
  });
  return nb::make_tuple(FE, JP, tau, psi, modulus);
}

// One function of the lane packs on every number of an array.
template <class T, class F>
View<T> each_lane(const Reals<T>& x, F&& f) {
  using R = Lanes<T>;
  const std::size_t n = x.shape(0);
  T* y;
  auto out = fresh<T>(y, {n});
  for (std::size_t p = 0; p < n; p += width<R>) {
    const int count = static_cast<int>(std::min<std::size_t>(width<R>, n - p));
    store(y + p, R(f(load<R>(x.data() + p, count))), count);
  }
  return out;
}

template <class T>
View<T> function_of(const std::string& name, const Reals<T>& x) {
  if (name == "exp") return each_lane<T>(x, [](auto a) { return exp(a); });
  if (name == "expm1") return each_lane<T>(x, [](auto a) { return expm1(a); });
  if (name == "log1p") return each_lane<T>(x, [](auto a) { return log1p(a); });
  if (name == "sinh") return each_lane<T>(x, [](auto a) { return sinh_positive(a); });
  if (name == "asinh") return each_lane<T>(x, [](auto a) { return asinh_positive(a); });
  throw nb::value_error("function: 'exp', 'expm1', 'log1p', 'sinh' or 'asinh'");
}

template <class T>
void bind_material_point(nb::module_& m) {
  m.attr("lanes") = lane_count<T>;
  m.def("svd", &svd<T>, nb::arg("F"), "Polar SVD of F (n, 3, 3): rotations U and V, singular values (n, 3).");
  m.def("isotropic_function", &isotropic_function_of<T>, nb::arg("F"), nb::arg("y"),
        "Eigenvalues (n, 3) of F F^T - I, the one that stands apart first, and the symmetric matrices (n, 3, "
        "3) "
        "with its eigenvectors and the eigenvalues y (n, 3).");
  m.def(
      "weights",
      [](const std::string& spline, const Reals<T>& x) {
        return with_spline(place_of(Splines{}, spline, "spline"),
                           [&](auto found) { return weights_of<T, decltype(found)>(x); });
      },
      nb::arg("spline"), nb::arg("x"), "First node (n,), weights and derivatives (n, K) at x (n,) in cells.");
  m.def(
      "function", &function_of<T>, nb::arg("name"), nb::arg("x"),
      "exp, expm1, log1p, sinh or asinh of x (n,) as the lane packs compute it; sinh and asinh for x >= 0.");
  m.def("law", &law_of<T>, nb::arg("name"), nb::arg("plasticity"), nb::arg("constants"), nb::arg("F_trial"),
        nb::arg("J_P"), nb::arg("strength") = nb::none(),
        "Return map of a law: F_E (n, 3, 3), J_P (n,), Kirchhoff stress tau (n, 3, 3) [Pa], energy psi (n,) "
        "[J/m3] and the largest acoustic modulus (n,) [Pa].");
}

}  // namespace neve::bind
