// The pairs of snow with snow and with boundaries, with the gradient of the kernel of each.
#pragma once

#include "neighbours/gather.hpp"
#include "sph/boundary.hpp"
#include "sph/state.hpp"

namespace neve {

// The entries of particle p are [begin[p], begin[p + 1]): rows of the others, and grad_p W. Arrays may be read one pack past
// their ends.
template <class T>
struct SphPairs {
  std::vector<std::uint32_t> begin{0};
  std::vector<std::int32_t> row;
  std::vector<T> gradient[3];  // [1/m4]

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

  // Call f(entry, how many, sums) for the packs of entries of particle p, and write the K sums over all lanes to `out`.
  // Lanes beyond `how many` have the gradient zero.
  template <int K, class F>
  NEVE_INLINE void sum(std::size_t p, T (&out)[K], F&& f) const {
    using R = Lanes<T>;
    R sums[K]{};
    for (std::uint32_t e = begin[p]; e < begin[p + 1]; e += width<R>)
      f(e, int(std::min<std::uint32_t>(width<R>, begin[p + 1] - e)), sums);
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
  set_gradients(kernel, s, s, snow);
  set_gradients(kernel, s, walls, boundary);
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
