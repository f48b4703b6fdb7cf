// State: everything per particle that changes or travels with the particle, as a structure of arrays.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>

namespace neve {

// An array on cache lines that may be read one line past its end (lane packs load whole lines).
template <class E>
class Column {
 public:
  void resize(std::size_t n) {
    const std::size_t bytes = ((n * sizeof(E) + 63) / 64 + 2) * 64;
    E* fresh = static_cast<E*>(::operator new(bytes, line));
    std::memset(static_cast<void*>(fresh), 0, bytes);
    if (data_) std::memcpy(static_cast<void*>(fresh), data_.get(), std::min(n, size_) * sizeof(E));
    data_.reset(fresh);
    size_ = n;
  }
  E* data() { return data_.get(); }
  const E* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  E& operator[](std::size_t i) { return data_.get()[i]; }
  const E& operator[](std::size_t i) const { return data_.get()[i]; }

 private:
  static constexpr std::align_val_t line{64};
  struct Free {
    void operator()(E* p) const { ::operator delete(p, line); }
  };
  std::unique_ptr<E[], Free> data_;
  std::size_t size_ = 0;
};

// Components of one quantity, `stride` apart, so that a vector is columns x, y, z of one allocation.
template <class T>
class Columns {
 public:
  explicit Columns(int components) : components_(components) {}
  void resize(std::size_t n) {
    const std::size_t stride = (n + 15) / 16 * 16 + 16;
    Column<T> fresh;
    if (components_ > 0) fresh.resize(stride * static_cast<std::size_t>(components_));
    for (int k = 0; k < components_; ++k) {
      if (stride_) std::memcpy(fresh.data() + k * stride, column(k), std::min(n, count_) * sizeof(T));
    }
    values_ = std::move(fresh);
    stride_ = stride;
    count_ = n;
  }
  T* column(int k) { return values_.data() + k * stride_; }
  const T* column(int k) const { return values_.data() + k * stride_; }
  int components() const { return components_; }
  std::size_t stride() const { return stride_; }
  std::size_t size() const { return count_; }
  std::size_t bytes() const { return values_.size() * sizeof(T); }

 private:
  int components_;
  Column<T> values_;
  std::size_t stride_ = 0, count_ = 0;
};

// As many as the type says.
template <class T, int Components>
class Field : public Columns<T> {
 public:
  Field() : Columns<T>(Components) {}
};

template <class T>
struct State {
  // `more_modes`: how many modes a particle has beyond v and C. `sleeps`: whether it may sleep. `heat`: whether it has heat.
  // `fine`: whether its position is kept to more than T.
  explicit State(int more_modes = 0, bool sleeps = false, bool heat = false, bool fine = false)
      : beyond(fine ? 3 : 0),
        modes(3 * more_modes),
        rest(sleeps ? rest_numbers : 0),
        enthalpy(heat ? 1 : 0),
        thermal(heat ? thermal_numbers : 0) {}

  bool has_heat() const { return thermal.components() > 0; }
  bool is_fine() const { return beyond.components() > 0; }

  // A coordinate of a particle [m].
  double place(int axis, std::size_t p) const {
    return double(x.column(axis)[p]) + (is_fine() ? double(beyond.column(axis)[p]) : 0.0);
  }

  std::size_t count = 0;
  Field<T, 3> x, v;   // position [m], velocity [m/s]
  Columns<T> beyond;  // if positions are fine: what is to be added to x, less than its rounding [m]
  Field<T, 9> C,
      F_E;  // affine velocity [1/s], elastic deformation gradient [1]; component 3 j + i is row i, column j
  Columns<T>
      modes;  // velocity modes beyond v and C, if the transfer has any [m/s]; component 3 k + i is axis i of mode 4 + k
  static constexpr int rest_numbers = 4;
  Columns<T> rest;  // if it may sleep: for how long it has rested [s], its mean velocity of late [m/s]
  static constexpr int thermal_numbers = 3;
  Columns<double> enthalpy;  // if it has heat [J], zero for ice at the melting point
  Columns<T>
      thermal;  // if it has heat: the share of water that stress follows, growth of strength by sintering, the largest
                // share that there was [1]
  Field<T, 6> tau;        // Kirchhoff stress [Pa]: xx yy zz xy xz yz; follows from F_E and J_P, see refresh()
  Field<T, 1> J_P;        // plastic volume change [1]
  Field<T, 1> m, V0;      // mass [kg], rest volume [m3]
  Field<T, 1> stiffness;  // factor on E0 [1]
  Field<T, 1> strength;   // factor on the thresholds of plastic flow [1]
  Column<std::uint16_t> material;  // row of the material table
  Column<std::uint32_t> id;        // birth number: the row order of the sources

  // Call f(column) for each column that a particle owns: what sorting permutes.
  template <class F>
  void each_column(F&& f) {
    each_field([&](auto& field) {
      for (int k = 0; k < field.components(); ++k) f(field.column(k));
    });
    f(material.data());
    f(id.data());
  }

  // How many particles there is room for.
  std::size_t capacity() const { return id.size(); }

  // Make room for n particles: columns move to other addresses.
  void reserve(std::size_t n) {
    each_field([&](auto& field) { field.resize(n); });
    material.resize(n);
    id.resize(n);
  }

  // Have n particles; new ones are at rest, not deformed, and without mass.
  void resize(std::size_t n) {
    if (n > capacity()) reserve(n);
    if (n > count)
      each_column([&](auto* column) { std::memset(column + count, 0, (n - count) * sizeof(*column)); });
    for (std::size_t p = count; p < n; ++p) {
      J_P.column(0)[p] = stiffness.column(0)[p] = strength.column(0)[p] = T(1);
      for (int k : {0, 4, 8}) F_E.column(k)[p] = T(1);
      if (has_heat()) thermal.column(1)[p] = T(1);
      id[p] = static_cast<std::uint32_t>(p);
    }
    count = n;
  }

  std::size_t bytes() {
    std::size_t sum = material.size() * sizeof(std::uint16_t) + id.size() * sizeof(std::uint32_t);
    each_field([&](auto& field) { sum += field.bytes(); });
    return sum;
  }

 private:
  template <class F>
  void each_field(F&& f) {
    f(x), f(v), f(beyond), f(C), f(modes), f(rest), f(enthalpy), f(thermal), f(F_E), f(tau), f(J_P), f(m),
        f(V0), f(stiffness), f(strength);
  }
};

}  // namespace neve
