// What is wrong with a state before a step is taken on it: users write into it.
#pragma once

#include "cpu/fields.hpp"
#include "cpu/material.hpp"
#include "mpm/model.hpp"
#include "threads.hpp"

namespace neve {

// The first row (by birth number) with a value that no snow has, and the name of its field; and the densest row.
struct Inspection {
  static constexpr std::uint32_t nobody = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t id = nobody;
  std::int64_t row = -1;
  const char* field = "";
  double crowding =
      0;  // the largest density of snow that flows over that of ice, or the most its own may become [1]
  std::int64_t densest = -1;

  // The crowding of rows from p on.
  template <class R>
  void see_densest(const R& crowded, std::size_t p) {
    if (!any(crowded > splat<R>(scalar_t<R>(crowding)))) return;
    for (int l = 0; l < width<R>; ++l) {
      if (crowded[l] > scalar_t<R>(crowding))
        crowding = crowded[l], densest = static_cast<std::int64_t>(p) + l;
    }
  }

  void merge(const Inspection& o) {
    if (o.id < id) id = o.id, row = o.row, field = o.field;
    if (o.crowding > crowding || (o.crowding == crowding && o.densest < densest))
      crowding = o.crowding, densest = o.densest;
  }
};

namespace detail {

template <class T>
bool finite(const Columns<T>& f, std::size_t p) {
  T sum{};
  for (int k = 0; k < f.components(); ++k) sum += f.column(k)[p] - f.column(k)[p];
  return sum == T(0);
}

// det F_E; 0 where F_E is singular to rounding.
template <class T>
double stretch_of(const State<T>& state, std::size_t p) {
  Mat3<double> F;
  double norm2 = 0;
  for (int k = 0; k < 9; ++k) {
    const double a = state.F_E.column(k)[p];
    F(k % 3, k / 3) = a, norm2 += a * a;
  }
  const double det = determinant(F);
  return det > std::numeric_limits<T>::epsilon() * norm2 * std::sqrt(norm2) ? det : std::min(det, 0.0);
}

// The field of particle p that has an impossible value, or none.
template <class T>
const char* impossible(const Model<T>& model, const State<T>& state, std::size_t p) {
  const auto positive = [&](const Field<T, 1>& f) { return finite(f, p) && f.column(0)[p] > T(0); };
  if (!finite(state.x, p)) return "x";
  if (!finite(state.beyond, p)) return "beyond";
  if (!finite(state.v, p)) return "v";
  if (!finite(state.C, p)) return "C";
  if (!finite(state.modes, p)) return "modes";
  if (!finite(state.F_E, p) || !(stretch_of(state, p) > 0)) return "F_E";
  if (!positive(state.J_P)) return "J_P";
  if (!positive(state.m)) return "m";
  if (!positive(state.V0)) return "V0";
  if (!positive(state.stiffness)) return "stiffness";
  if (!finite(state.strength, p) || state.strength.column(0)[p] < T(0)) return "strength";
  if (state.has_heat()) {
    const T f = state.thermal.column(0)[p];
    if (!finite(state.enthalpy, p)) return "enthalpy";
    if (!finite(state.thermal, p) || f < T(0) || f > T(1) || state.thermal.column(1)[p] < T(1) ||
        state.thermal.column(2)[p] < T(0) || state.thermal.column(2)[p] > T(1))
      return "thermal";
  }
  if (state.material[p] >= model.snows.size()) return "material";
  return nullptr;
}

// Whether a pack is all right beyond doubt, at a glance: of what is not, impossible() tells.
template <class T>
bool sound(const Model<T>& model, const State<T>& state, std::size_t p, int count) {
  using R = Lanes<T>;
  R differ{};  // 0, or not a number
  const auto see = [&](const Columns<T>& f) {
    for (int k = 0; k < f.components(); ++k) {
      const R a = load<R>(f.column(k) + p, count);
      differ = differ + (a - a);
    }
  };
  see(state.x), see(state.beyond), see(state.v), see(state.C), see(state.modes), see(state.F_E);
  see(state.strength);
  R least = load<R>(state.J_P.column(0) + p, count);
  for (const Field<T, 1>* f : {&state.J_P, &state.m, &state.V0, &state.stiffness}) {
    see(*f);
    least = min(least, load<R>(f->column(0) + p, count));
  }
  const Mat3<R> F = load_matrix<R>(state.F_E, p, count);
  const R norm2 = dot(F.c0, F.c0) + dot(F.c1, F.c1) + dot(F.c2, F.c2);
  const R zero = splat<R>(0), rounding = norm2 * sqrt(norm2) * (T(16) * std::numeric_limits<T>::epsilon());
  const auto good = (differ == zero) & (least > zero) &
                    (load<R>(state.strength.column(0) + p, count) >= zero) & (determinant(F) > rounding);
  const R bad = select(good, zero, splat<R>(1));
  if (any(first_lanes<R>(count) & (bad > zero))) return false;
  for (int l = 0; l < count; ++l) {
    if (state.has_heat() && impossible(model, state, p + static_cast<std::size_t>(l))) return false;
    if (state.material[p + static_cast<std::size_t>(l)] >= model.snows.size()) return false;
  }
  return true;
}

// The density of snow that flows over that of ice, or over the most that it may become; 0 for other snow.
template <class T>
Lanes<T> crowding(const Model<T>& model, const State<T>& state, std::size_t p, int count) {
  using R = Lanes<T>;
  const PackIce<T> pack(model, state, p, count);
  const R J = determinant(load_matrix<R>(state.F_E, p, count)) * load<R>(state.J_P.column(0) + p, count);
  return pack.mark * pack.ice.J_ice / select(pack.mark > R{}, J, splat<R>(1));
}

}  // namespace detail

template <class T>
Inspection inspect(const Model<T>& model, const State<T>& state) {
  constexpr int wide = width<Lanes<T>>;
  constexpr std::size_t chunk = 1024;
  return merge_each<Inspection>((state.count + chunk - 1) / chunk, [&](std::size_t c) {
    Inspection found;
    const std::size_t end = std::min(state.count, (c + 1) * chunk);
    for (std::size_t p = c * chunk; p < end; p += wide) {
      const int count = std::min(wide, static_cast<int>(end - p));
      if (detail::sound(model, state, p, count)) {
        found.see_densest(detail::crowding(model, state, p, count), p);
        continue;
      }
      for (std::size_t q = p; q < p + static_cast<std::size_t>(count); ++q) {
        if (const char* field = detail::impossible(model, state, q)) {
          Inspection one;
          one.id = state.id[q], one.row = static_cast<std::int64_t>(q), one.field = field;
          found.merge(one);
        } else {
          found.see_densest(detail::crowding(model, state, q, 1), q);
        }
      }
    }
    return found;
  });
}

}  // namespace neve
