// A grid of cells that holds where particles were when their neighbours were listed. Particles move in it one by one.
#pragma once

#include <unordered_map>

#include "mpm/block_key.hpp"
#include "neighbours/gather.hpp"
#include "neighbours/search.hpp"

namespace neve {

// Cells are kept in bricks of 4x4x4, which know their 27 neighbours; the particles of a cell in buckets, whose free places hold
// a point that is near nothing.
template <class T>
class StartGrid {
 public:
  static constexpr std::int32_t none = -1;
  static constexpr int in_bucket = 16;
  static constexpr T nowhere = T(1e15);  // [m]

  // Forget all, and have cells of `edge` [m] for particles [0, rows).
  void clear(double edge, std::size_t rows) {
    inv_ = T(1 / edge);
    buckets_.clear(), bricks_.clear();
    names_.clear();
    place_.assign(rows, none);
    if (start_.size() != rows) start_.resize(rows);
  }

  // Where particle p was [m], and how far it may move from there [m] (.d).
  const Quartet<T>& start(std::size_t p) const { return start_[p]; }
  const Quartet<T>* starts() const { return start_.data(); }
  std::size_t bytes() const {
    return buckets_.size() * sizeof(Bucket) + bricks_.size() * sizeof(Brick) +
           start_.size() * sizeof(start_[0]);
  }

  // Put particle p, named `id`, where it is now. Throws std::domain_error with the name of one that is lost.
  void put(std::int32_t p, const Quartet<T>& now, std::uint32_t id) {
    std::int32_t at[3];
    const T x[3] = {now.a, now.b, now.c};
    for (int k = 0; k < 3; ++k) {
      const T u = std::floor(x[k] * inv_);
      if (!(std::abs(u) < T(detail::cell_limit))) throw std::domain_error(std::to_string(id));
      at[k] = std::int32_t(u);
    }
    start_[std::size_t(p)] = now;
    const BlockCoord brick{at[0] >> 2, at[1] >> 2, at[2] >> 2};
    const int cell = (at[0] & 3) | (at[1] & 3) << 2 | (at[2] & 3) << 4;
    std::int32_t& place = place_[std::size_t(p)];
    if (place != none) {
      const Bucket& now_in = buckets_[std::size_t(place / in_bucket)];
      const std::int32_t own = now_in.brick;
      const BlockCoord there = bricks_[std::size_t(own)].at;
      if (there.x == brick.x && there.y == brick.y && there.z == brick.z) {
        if (now_in.cell != cell) take_out(place), place = free_place(own, cell);
        set(place, now, p);
        return;
      }
      take_out(place);
    }
    place = free_place(brick_of(brick), cell);
    set(place, now, p);
  }

  // Append the rows whose starts are within `near` [m] and the ways of both of that of particle p, but p, in rising order.
  // Returns how many.
  std::size_t find(std::size_t p, T near, detail::FoundRows& found) const {
    const Bucket& own = buckets_[std::size_t(place_[p] / in_bucket)];
    const Brick& home = bricks_[std::size_t(own.brick)];
    const int cx = own.cell & 3, cy = own.cell >> 2 & 3, cz = own.cell >> 4;
    std::size_t n = 0;
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = cx + dx, y = cy + dy, z = cz + dz;
          const int beside = ((x + 4) >> 2) + 3 * ((y + 4) >> 2) + 9 * ((z + 4) >> 2);
          const std::int32_t brick = home.beside[std::size_t(beside)];
          if (brick == none) continue;
          const std::size_t cell = std::size_t((x & 3) | (y & 3) << 2 | (z & 3) << 4);
          for (std::int32_t b = bricks_[std::size_t(brick)].first[cell]; b != none;
               b = buckets_[std::size_t(b)].next)
            n += hits(buckets_[std::size_t(b)], p, near, found.room(n + 2 * in_bucket) + n);
        }
      }
    }
    sort_rows(found.room(2 * n + 2 * in_bucket), n);
    found.count += n;
    return n;
  }

 private:
  struct alignas(64) Bucket {
    T x[in_bucket], y[in_bucket], z[in_bucket], way[in_bucket];
    std::int32_t row[in_bucket];
    std::int32_t count, next, brick, cell;
  };
  struct Brick {
    BlockCoord at;
    std::array<std::int32_t, 27> beside;
    std::array<std::int32_t, 64> first;
  };

  void set(std::int32_t place, const Quartet<T>& now, std::int32_t p) {
    Bucket& b = buckets_[std::size_t(place / in_bucket)];
    const int i = place % in_bucket;
    b.x[i] = now.a, b.y[i] = now.b, b.z[i] = now.c, b.way[i] = now.d, b.row[i] = p;
  }
  void take_out(std::int32_t place) {
    Bucket& b = buckets_[std::size_t(place / in_bucket)];
    const int i = place % in_bucket, last = --b.count;
    if (i != last) {
      set(place, {b.x[last], b.y[last], b.z[last], b.way[last]}, b.row[last]);
      place_[std::size_t(b.row[last])] = place;
    }
    b.x[last] = nowhere;
  }
  std::int32_t free_place(std::int32_t brick, int cell) {
    std::int32_t b = bricks_[std::size_t(brick)].first[std::size_t(cell)], last = none;
    while (b != none && buckets_[std::size_t(b)].count == in_bucket)
      last = b, b = buckets_[std::size_t(b)].next;
    if (b == none) {
      b = std::int32_t(buckets_.size());
      Bucket fresh{};
      std::fill_n(fresh.x, in_bucket, nowhere);
      fresh.next = none, fresh.brick = brick, fresh.cell = cell;
      buckets_.push_back(fresh);
      (last == none ? bricks_[std::size_t(brick)].first[std::size_t(cell)]
                    : buckets_[std::size_t(last)].next) = b;
    }
    return b * in_bucket + buckets_[std::size_t(b)].count++;
  }
  std::int32_t brick_of(const BlockCoord& at) {
    const auto b = static_cast<std::int32_t>(bricks_.size());
    if (const auto [known, fresh] = names_.try_emplace(key_of(at), b); !fresh) return known->second;
    Brick fresh{at, {}, {}};
    fresh.first.fill(none);
    bricks_.push_back(fresh);
    for (std::int32_t n = 0; n < 27; ++n) {
      const auto found = names_.find(key_of({at.x + n % 3 - 1, at.y + n / 3 % 3 - 1, at.z + n / 9 - 1}));
      const std::int32_t other = found == names_.end() ? none : found->second;
      bricks_[std::size_t(b)].beside[std::size_t(n)] = other;
      if (other != none) bricks_[std::size_t(other)].beside[std::size_t(26 - n)] = b;
    }
    return b;
  }

  std::size_t hits(const Bucket& b, std::size_t p, T near, std::int32_t* out) const {
    const Quartet<T>& own = start_[p];
    std::size_t n = 0;
#if defined(__AVX512F__)
    if constexpr (std::is_same_v<T, float>) {
      const __m512 dx = _mm512_sub_ps(_mm512_load_ps(b.x), _mm512_set1_ps(own.a));
      const __m512 dy = _mm512_sub_ps(_mm512_load_ps(b.y), _mm512_set1_ps(own.b));
      const __m512 dz = _mm512_sub_ps(_mm512_load_ps(b.z), _mm512_set1_ps(own.c));
      const __m512 d2 = _mm512_fmadd_ps(dz, dz, _mm512_fmadd_ps(dy, dy, _mm512_mul_ps(dx, dx)));
      const __m512 ways = _mm512_add_ps(_mm512_load_ps(b.way), _mm512_set1_ps(own.d));
      const __m512 reach = _mm512_add_ps(ways, _mm512_set1_ps(near));
      const __m512i rows = _mm512_load_si512(b.row);
      const auto all = __mmask16(
          _mm512_mask_cmp_ps_mask(_mm512_cmpneq_epi32_mask(rows, _mm512_set1_epi32(std::int32_t(p))), d2,
                                  _mm512_mul_ps(reach, reach), _CMP_LE_OQ));
      _mm512_storeu_si512(out, _mm512_maskz_compress_epi32(all, rows));
      return std::size_t(std::popcount(std::uint32_t(all)));
    }
#elif defined(__AVX2__)
    if constexpr (std::is_same_v<T, float>) {
      std::uint32_t all = 0;
      for (int k = 0; k < b.count; k += 8) {
        const __m256 dx = _mm256_sub_ps(_mm256_load_ps(b.x + k), _mm256_set1_ps(own.a));
        const __m256 dy = _mm256_sub_ps(_mm256_load_ps(b.y + k), _mm256_set1_ps(own.b));
        const __m256 dz = _mm256_sub_ps(_mm256_load_ps(b.z + k), _mm256_set1_ps(own.c));
        const __m256 d2 = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        const __m256 ways = _mm256_add_ps(_mm256_load_ps(b.way + k), _mm256_set1_ps(own.d));
        const __m256 reach = _mm256_add_ps(ways, _mm256_set1_ps(near));
        const __m256 hits = _mm256_cmp_ps(d2, _mm256_mul_ps(reach, reach), _CMP_LE_OQ);
        all |= std::uint32_t(_mm256_movemask_ps(hits)) << k;
      }
      for (; all != 0; all &= all - 1) {
        out[n] = b.row[std::countr_zero(all)];
        n += std::size_t(out[n]) != p;
      }
      return n;
    }
#endif
    for (int i = 0; i < b.count; ++i) {
      const T dx = b.x[i] - own.a, dy = b.y[i] - own.b, dz = b.z[i] - own.c;
      const T reach = near + (b.way[i] + own.d);
      out[n] = b.row[i];
      n += (dx * dx + dy * dy + dz * dz <= reach * reach) & (std::size_t(b.row[i]) != p);
    }
    return n;
  }

  // Sort n different rows; as many places and a pack are free behind them.
  static void sort_rows(std::int32_t* rows, std::size_t n) {
    constexpr std::size_t pack = 16, most = 64;
    if (n > most) {
      std::sort(rows, rows + n);
      return;
    }
    std::int32_t from[most], rank[most] = {};
    std::copy_n(rows, n, from);
    std::fill(from + n, from + (n + pack - 1) / pack * pack, 0);
    for (std::size_t j = 0; j < n; ++j) {
      const std::int32_t here = from[j];
      for (std::size_t i = 0; i < n; i += pack) {
        for (std::size_t l = 0; l < pack; ++l) rank[i + l] += here < from[i + l];
      }
    }
    for (std::size_t i = 0; i < n; ++i) rows[rank[i]] = from[i];
  }

  T inv_{};
  std::vector<Bucket> buckets_;
  std::vector<Brick> bricks_;
  std::unordered_map<BlockKey, std::int32_t> names_;  // of bricks
  std::vector<std::int32_t> place_;                   // by row: bucket times in_bucket, and place in it
  Column<Quartet<T>> start_;
};

}  // namespace neve
