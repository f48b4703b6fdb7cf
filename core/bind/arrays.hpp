// From and to NumPy: views of the core's memory, without a copy; points, and values that Python takes over.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <vector>

#include "math/mat3.hpp"
#include "mpm/state.hpp"

namespace neve::bind {

namespace nb = nanobind;

template <class E>
using View = nb::ndarray<nb::numpy, E>;
template <class T, class... Shape>
using In = nb::ndarray<const T, Shape..., nb::c_contig, nb::device::cpu>;

// (n,) (n, 3) or (n, 3, 3) views of a field's columns. The owner keeps the memory alive.
template <class T, int Components>
View<T> view(Field<T, Components>& f, std::size_t n, nb::handle owner) {
  const auto s = std::int64_t(f.stride());
  if constexpr (Components == 1) {
    return View<T>(f.column(0), {n}, owner, {1});
  } else if constexpr (Components == 9) {
    return View<T>(f.column(0), {n, 3, 3}, owner, {1, s, 3 * s});
  } else {
    return View<T>(f.column(0), {n, std::size_t(Components)}, owner, {1, s});
  }
}
// (n, k, 3): vectors, three columns each.
template <class T>
View<T> view(Columns<T>& f, std::size_t n, nb::handle owner) {
  const auto s = std::int64_t(f.stride());
  const auto k = std::size_t(f.components() / 3);
  return View<T>(f.column(0), {n, k, 3}, owner, {1, 3 * s, s});
}
template <class E>
View<E> view(Column<E>& c, std::size_t n, nb::handle owner) {
  return View<E>(c.data(), {n}, owner, {1});
}

// A fresh array of the given shape, owned by Python.
template <class T>
View<T> fresh(T*& data, std::initializer_list<std::size_t> shape) {
  std::size_t size = 1;
  for (std::size_t n : shape) size *= n;
  data = new T[size > 0 ? size : 1]();
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return View<T>(data, shape, owner);
}

inline std::vector<Vec3<float>> points_of(const In<float, nb::shape<-1, 3>>& x) {
  std::vector<Vec3<float>> out(x.shape(0));
  for (std::size_t p = 0; p < out.size(); ++p) out[p] = {x(p, 0), x(p, 1), x(p, 2)};
  return out;
}

// An array of the given shape that takes the values over.
template <class T>
View<T> array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return View<T>(kept->data(), shape, owner);
}

}  // namespace neve::bind
