// Particles that come and go: rows of a state that are found in a box, dropped, or copied to where there is more room.
#pragma once

#include <vector>

#include "mpm/state.hpp"
#include "threads.hpp"

namespace neve {

// The rows, in rising order, of particles in the closed box from `low` to `high` [m]. x is compared in double.
template <class T>
std::vector<std::uint32_t> rows_in_box(const State<T>& state, const double* low, const double* high) {
  std::vector<std::vector<std::uint32_t>> found(static_cast<std::size_t>(thread_count()));
  each_chunk(state.count, [&](int chunk, std::size_t begin, std::size_t end) {
    auto& mine = found[static_cast<std::size_t>(chunk)];
    for (std::size_t p = begin; p < end; ++p) {
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        const double x = state.place(k, p);
        inside = inside && low[k] <= x && x <= high[k];
      }
      if (inside) mine.push_back(static_cast<std::uint32_t>(p));
    }
  });
  std::vector<std::uint32_t> rows;
  for (const auto& part : found) rows.insert(rows.end(), part.begin(), part.end());
  return rows;
}

// How rows are dropped: the last particles take the places of those that go, in the order of their rows, so that the work
// follows the number of rows alone.
struct Refill {
  std::size_t left;                     // particles that stay
  std::vector<std::uint32_t> to, from;  // rows

  // `rows` rise strictly; `count`: particles before.
  Refill(std::size_t count, const std::uint32_t* rows, std::size_t n) : left(count - n) {
    std::size_t gone = std::size_t(std::lower_bound(rows, rows + n, left) - rows);
    to.assign(rows, rows + gone);
    for (std::size_t p = left; p < count; ++p) {
      if (gone < n && rows[gone] == p) {
        ++gone;
      } else {
        from.push_back(static_cast<std::uint32_t>(p));
      }
    }
  }
  template <class E>
  void operator()(E* column) const {
    for (std::size_t k = 0; k < to.size(); ++k) column[to[k]] = column[from[k]];
  }
};

// Drop the particles at `rows`, which rise strictly.
template <class T>
void drop(State<T>& state, const std::uint32_t* rows, std::size_t n) {
  const Refill refill(state.count, rows, n);
  state.each_column([&](auto* column) { refill(column); });
  state.count = refill.left;
}

// A copy of the state with room for `capacity` particles, at least as many as it has.
template <class T>
State<T> with_room(const State<T>& state, std::size_t capacity) {
  State<T> out(state.modes.components() / 3, state.rest.components() > 0, state.has_heat(), state.is_fine());
  out.reserve(std::max(capacity, state.count));
  out.resize(state.count);
  std::vector<const void*> source;
  const_cast<State<T>&>(state).each_column([&](auto* column) { source.push_back(column); });
  std::size_t k = 0;
  out.each_column([&](auto* column) { std::memcpy(column, source[k++], state.count * sizeof(*column)); });
  return out;
}

}  // namespace neve
