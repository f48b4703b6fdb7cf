// The pairs of snow with snow and with boundaries, with the gradient of the kernel of each.
#pragma once

#include "cpu/fields.hpp"
#include "neighbours/gather.hpp"
#include "sph/boundary.hpp"
#include "sph/state.hpp"

namespace neve {

// The entries of particle p are [begin[p], begin[p + 1]): rows of the others, and grad_p W; those from split[p] on, if there
// are splits, are of the other phase: water for snow, snow for water. Arrays may be read one pack past their ends.
template <class T>
struct SphPairs {
  std::vector<std::uint32_t> begin{0}, split;
  std::vector<std::int32_t> row;
  std::vector<T> gradient[3];  // [1/m4]
  std::vector<T> filled;       // of water: how much of a kernel boundaries fill [1]

  std::int32_t* resize(std::size_t n) {
    constexpr std::size_t spare = 64;
    if (row.size() < n + spare) {
      const std::size_t room = n + n / 8 + spare;
      row.resize(room);
      for (auto& g : gradient) g.resize(room);
    }
    std::fill_n(row.begin() + std::ptrdiff_t(n), spare, 0);
    return row.data();
  }
  std::size_t bytes() const { return row.size() * (sizeof(std::int32_t) + 3 * sizeof(T)); }

  template <class R>
  NEVE_INLINE Vec3<R> slope(std::uint32_t e, int count) const {
    return {load<R>(gradient[0].data() + e, count), load<R>(gradient[1].data() + e, count),
            load<R>(gradient[2].data() + e, count)};
  }

  // The end of the entries of particle p of its own phase.
  NEVE_INLINE std::uint32_t own_end(std::size_t p) const { return split.empty() ? begin[p + 1] : split[p]; }

  // Of one entry.
  Vec3<T> slope_at(std::uint32_t e) const { return {gradient[0][e], gradient[1][e], gradient[2][e]}; }

  // Call f(entry, how many, sums) for the packs of entries of particle p, and write the K sums over all lanes to `out`.
  // Lanes beyond `how many` have the gradient zero.
  template <int K, class F>
  NEVE_INLINE void sum(std::size_t p, T (&out)[K], F&& f) const {
    sum_of(begin[p], own_end(p), out, f);
  }
  // The same over the entries of the other phase.
  template <int K, class F>
  NEVE_INLINE void sum_across(std::size_t p, T (&out)[K], F&& f) const {
    sum_of(split[p], begin[p + 1], out, f);
  }

 private:
  template <int K, class F>
  NEVE_INLINE void sum_of(std::uint32_t first, std::uint32_t last, T (&out)[K], F&& f) const {
    using R = Lanes<T>;
    R sums[K]{};
    for (std::uint32_t e = first; e < last; e += width<R>)
      f(e, int(std::min<std::uint32_t>(width<R>, last - e)), sums);
    for (int k = 0; k < K; ++k) out[k] = sum_lanes(sums[k]);
  }
};

// Call f(p) for all of `count` particles, in parallel.
template <class F>
void each_row(std::size_t count, F&& f) {
  constexpr std::size_t chunk = 64;
  each_index((count + chunk - 1) / chunk, [&](std::size_t c) {
    for (std::size_t p = c * chunk; p < std::min(count, (c + 1) * chunk); ++p) f(p);
  });
}

// Rows whose sums over neighbours are finished together, pack by pack.
inline constexpr std::size_t rows_together = 64;

// Call f(begin, end) for all of `count` particles in parts of `rows_together`, in parallel.
template <class F>
void each_rows_together(std::size_t count, F&& f) {
  each_index((count + rows_together - 1) / rows_together,
             [&](std::size_t c) { f(c * rows_together, std::min(count, (c + 1) * rows_together)); });
}

// Call f(p, how many) for the packs of all of `count` particles, in parallel.
template <class T, class F>
void each_pack(std::size_t count, F&& f) {
  constexpr std::size_t lanes = width<Lanes<T>>;
  each_rows_together(count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; p += lanes) f(p, int(std::min<std::size_t>(lanes, end - p)));
  });
}

// The sum of f(p) over all of `count` particles, in chunks whose sums are added in order: the same bits for any number of
// threads.
template <class F>
double sum_rows(std::size_t count, F&& f) {
  constexpr std::size_t chunk = 256;
  std::vector<double> parts((count + chunk - 1) / chunk);
  each_index(parts.size(), [&](std::size_t c) {
    double sum = 0;
    for (std::size_t p = c * chunk; p < std::min(count, (c + 1) * chunk); ++p) sum += f(p);
    parts[c] = sum;
  });
  double total = 0;
  for (double part : parts) total += part;
  return total;
}

// The largest of f(p), which is never below zero, over all of `count` particles.
template <class F>
double largest_of_rows(std::size_t count, F&& f) {
  struct Largest {
    double value = 0;
    void merge(const Largest& o) { value = !(value >= o.value) ? o.value : value; }
  };
  constexpr std::size_t chunk = 256;
  return merge_each<Largest>((count + chunk - 1) / chunk,
                             [&](std::size_t c) {
                               Largest mine;
                               for (std::size_t p = c * chunk; p < std::min(count, (c + 1) * chunk); ++p)
                                 mine.value = std::max(mine.value, f(p));
                               return mine;
                             })
      .value;
}

template <class T>
NEVE_INLINE Vec3<T> vector_at(const Columns<T>& f, std::size_t p) {
  return {f.column(0)[p], f.column(1)[p], f.column(2)[p]};
}
template <class T>
NEVE_INLINE void set_vector(Columns<T>& f, std::size_t p, const Vec3<T>& a) {
  for (int k = 0; k < 3; ++k) f.column(k)[p] = a[k];
}
template <class T>
NEVE_INLINE Mat3<T> matrix_at(const Field<T, 9>& f, std::size_t p) {
  Mat3<T> a;
  for (int k = 0; k < 9; ++k) a(k % 3, k / 3) = f.column(k)[p];
  return a;
}
template <class T>
NEVE_INLINE void set_matrix(Field<T, 9>& f, std::size_t p, const Mat3<T>& a) {
  for (int k = 0; k < 9; ++k) f.column(k)[p] = a(k % 3, k / 3);
}

template <class T>
NEVE_INLINE Sym3<T> symmetric_at(const Field<T, 6>& f, std::size_t p) {
  return {f.column(0)[p], f.column(1)[p], f.column(2)[p], f.column(3)[p], f.column(4)[p], f.column(5)[p]};
}
template <class T>
NEVE_INLINE void set_symmetric(Field<T, 6>& f, std::size_t p, const Sym3<T>& a) {
  const T values[6] = {a.xx, a.yy, a.zz, a.xy, a.xz, a.yz};
  for (int k = 0; k < 6; ++k) f.column(k)[p] = values[k];
}

// Vectors as rows that others gather: that of particle p + l is row `of` (p + l) + `which`.
template <class R>
NEVE_INLINE void store_rows(const Vec3<R>& a, Quartet<scalar_t<R>>* rows, std::size_t p, int count,
                            std::size_t of = 1, int which = 0) {
  using T = scalar_t<R>;
  alignas(64) T lane[3][width<R>];
  for (int k = 0; k < 3; ++k) store(lane[k], a[k], width<R>);
  for (int l = 0; l < count; ++l)
    rows[of * (p + std::size_t(l)) + std::size_t(which)] = {lane[0][l], lane[1][l], lane[2][l], T(0)};
}

// Room for the search, used again from step to step.
struct SphSearch {
  std::vector<std::uint32_t> order, order_of_walls;
  std::vector<std::array<std::int32_t, 3>> at, at_of_walls;
  std::vector<detail::FoundRows> found;
};

// Sort snow and boundary by cell, and list the pairs within the support, with their gradients. Throws std::domain_error with
// the birth number of a particle that is lost.
template <class T>
void find_pairs(const CubicKernel<T>& kernel, SphState<T>& s, SphBoundary<T>& walls, SphSearch& room,
                SphPairs<T>& snow, SphPairs<T>& boundary) {
  const double h = double(kernel.h);
  CellBounds bounds = cell_bounds(s, h, room.at);
  bounds.merge(cell_bounds(walls, h, room.at_of_walls));
  const Cells cells = sorted_cells(room.at, bounds, room.order);
  const Cells of_walls = sorted_cells(room.at_of_walls, bounds, room.order_of_walls);
  reorder(s, room.order), reorder(walls, room.order_of_walls);
  const T reach2 = kernel.h * kernel.h;
  find_rows(s, cells, s, cells, reach2, room.found, snow.begin,
            [&](std::size_t n) { return snow.resize(n); });
  find_rows(s, cells, walls, of_walls, reach2, room.found, boundary.begin,
            [&](std::size_t n) { return boundary.resize(n); });
  split_phases(s, snow);
  set_gradients(kernel, s, s, snow);
  set_gradients(kernel, s, walls, boundary);
}

// Put the entries of the other phase behind those of the particle's own, each in their order.
template <class T>
void split_phases(const SphState<T>& s, SphPairs<T>& pairs) {
  pairs.split.clear();
  if (!s.has_water()) return;
  pairs.split.resize(s.count);
  each_row(s.count, [&](std::size_t p) {
    const auto first = pairs.row.begin() + std::ptrdiff_t(pairs.begin[p]);
    const auto last = pairs.row.begin() + std::ptrdiff_t(pairs.begin[p + 1]);
    const bool water = s.is_water(p);
    const auto middle = std::stable_partition(
        first, last, [&](std::int32_t row) { return s.is_water(std::size_t(row)) == water; });
    pairs.split[p] = pairs.begin[p] + std::uint32_t(middle - first);
  });
}

template <class T, class Others>
void set_gradients(const CubicKernel<T>& kernel, const SphState<T>& s, const Others& others,
                   SphPairs<T>& pairs) {
  using R = Lanes<T>;
  each_row(s.count, [&](std::size_t p) {
    for (std::uint32_t e = pairs.begin[p]; e < pairs.begin[p + 1]; e += width<R>) {
      const int count = int(std::min<std::uint32_t>(width<R>, pairs.begin[p + 1] - e));
      Vec3<R> x;
      for (int k = 0; k < 3; ++k)
        x[k] = s.x.column(k)[p] - gather<R>(others.x.column(k), pairs.row.data() + e);
      const R slope = kernel.slope(dot(x, x));
      for (int k = 0; k < 3; ++k) store(pairs.gradient[k].data() + e, R(x[k] * slope), count);
    }
  });
}

}  // namespace neve
