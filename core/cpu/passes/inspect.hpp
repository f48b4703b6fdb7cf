// What is wrong with a state before a step is taken on it: users write into it.
#pragma once

#include "constitutive/ice.hpp"
#include "cpu/fields.hpp"
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
  if (!finite(state.v, p)) return "v";
  if (!finite(state.C, p)) return "C";
  if (!finite(state.modes, p)) return "modes";
  if (!finite(state.F_E, p) || !(stretch_of(state, p) > 0)) return "F_E";
  if (!positive(state.J_P)) return "J_P";
  if (!positive(state.m)) return "m";
  if (!positive(state.V0)) return "V0";
  if (!positive(state.stiffness)) return "stiffness";
  if (!finite(state.strength, p) || state.strength.column(0)[p] < T(0)) return "strength";
  if (state.material[p] >= model.snows.size()) return "material";
  return nullptr;
}

}  // namespace detail

template <class T>
Inspection inspect(const Model<T>& model, const State<T>& state) {
  constexpr std::size_t chunk = 1024;
  return merge_each<Inspection>((state.count + chunk - 1) / chunk, [&](std::size_t c) {
    Inspection found;
    for (std::size_t p = c * chunk; p < std::min(state.count, (c + 1) * chunk); ++p) {
      Inspection one;
      if (const char* field = detail::impossible(model, state, p)) {
        one.id = state.id[p], one.row = static_cast<std::int64_t>(p), one.field = field;
      } else if (model.snows[state.material[p]].plastic) {
        const double m = state.m.column(0)[p], V0 = state.V0.column(0)[p], J_P = state.J_P.column(0)[p];
        one.crowding = Ice<double>::of(m, V0).J_ice / (detail::stretch_of(state, p) * J_P);
        one.densest = static_cast<std::int64_t>(p);
      }
      found.merge(one);
    }
    return found;
  });
}

}  // namespace neve
