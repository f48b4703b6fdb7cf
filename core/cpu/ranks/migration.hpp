// Particles that go from one rank to another, as bytes: column after column.
#pragma once

#include <cstring>
#include <numeric>
#include <utility>

#include "cpu/grid/sort.hpp"
#include "cpu/ranks/border.hpp"
#include "mpm/population.hpp"

namespace neve {

// Of each particle, the key of the home that it is in. Throws std::domain_error on a lost particle.
template <class T>
std::vector<BlockKey> homes_now(const Model<T>& model, const State<T>& state) {
  const detail::Placing<T> placing = detail::placing_of(model);
  std::vector<BlockKey> keys(state.count);
  std::vector<std::int64_t> lost(static_cast<std::size_t>(thread_count()), -1);
  each_chunk(state.count, [&](int chunk, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (!placing.home(state, p, keys[p]))
        detail::note_lost(state, p, lost[static_cast<std::size_t>(chunk)]);
    }
  });
  detail::throw_if_lost(state, lost);
  return keys;
}

// The rank that owns each key: of a run of one key it is looked for once.
inline std::vector<std::int32_t> owners_of(const std::vector<BlockKey>& keys,
                                           const std::vector<BlockKey>& cuts) {
  std::vector<std::int32_t> owners(keys.size());
  for (std::size_t p = 0; p < keys.size(); ++p)
    owners[p] = p > 0 && keys[p] == keys[p - 1] ? owners[p - 1] : owner_of(cuts, keys[p]);
  return owners;
}

// Bytes of one particle.
template <class T>
std::size_t row_bytes(State<T>& state) {
  std::size_t bytes = 0;
  state.each_column([&](auto* column) { bytes += sizeof(*column); });
  return bytes;
}

// Copy rows to `to`, n row_bytes.
template <class T>
void pack_rows(State<T>& state, const std::uint32_t* rows, std::size_t n, char* to) {
  state.each_column([&](auto* column) {
    constexpr std::size_t size = sizeof(*column);
    for (std::size_t k = 0; k < n; ++k) std::memcpy(to + k * size, column + rows[k], size);
    to += n * size;
  });
}

// The same back, into these rows.
template <class T>
void unpack_rows(State<T>& state, const std::uint32_t* rows, std::size_t n, const char* from) {
  state.each_column([&](auto* column) {
    constexpr std::size_t size = sizeof(*column);
    for (std::size_t k = 0; k < n; ++k) std::memcpy(column + rows[k], from + k * size, size);
    from += n * size;
  });
}

// The key of the home that a row was in at the last sort; 0 before the first one.
template <class T>
BlockKey home_then(const Grid<T>& grid, std::uint32_t row) {
  const auto after = std::upper_bound(grid.homes.begin(), grid.homes.end(), row,
                                      [](std::uint32_t p, const Home& home) { return p < home.begin; });
  return after == grid.homes.begin() ? 0 : key_of((after - 1)->at);
}

// Note in which home and row of the last sort each particle is, before some go.
template <class T>
void note_order(const State<T>& state, Grid<T>& grid) {
  EarlierOrder& earlier = grid.earlier;
  earlier.home.assign(state.count, 0);
  earlier.row.resize(state.count);
  std::iota(earlier.row.begin(), earlier.row.end(), 0u);
  for (const Home& home : grid.homes) {
    const auto first = earlier.home.begin() + home.begin;
    std::fill(first, first + home.count, key_of(home.at));
  }
  earlier.stayed = state.count;
}

// Let the particles at `rows`, which rise strictly, go. Call note_order() before.
template <class T>
void depart(State<T>& state, Grid<T>& grid, const std::uint32_t* rows, std::size_t n) {
  const Refill refill(state.count, rows, n);
  state.each_column([&](auto* column) { refill(column); });
  refill(grid.earlier.home.data()), refill(grid.earlier.row.data());
  state.count = grid.earlier.stayed = refill.left;
  grid.earlier.home.resize(refill.left), grid.earlier.row.resize(refill.left);
}

// Let particles come, from `bytes` of pack_rows(), that were in these homes and rows. Columns may move to other addresses.
template <class T>
void arrive(State<T>& state, Grid<T>& grid, const BlockKey* home, const std::uint32_t* row, std::size_t n,
            const char* bytes) {
  const std::size_t before = state.count;
  if (before + n > state.capacity()) state.reserve((before + n) + (before + n) / 4);
  state.resize(before + n);
  std::vector<std::uint32_t> rows(n);
  std::iota(rows.begin(), rows.end(), static_cast<std::uint32_t>(before));
  unpack_rows(state, rows.data(), n, bytes);
  grid.earlier.home.insert(grid.earlier.home.end(), home, home + n);
  grid.earlier.row.insert(grid.earlier.row.end(), row, row + n);
}

}  // namespace neve
