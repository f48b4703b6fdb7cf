// Vectors on the nodes of the grid, as an implicit step computes with them: four numbers a node, of which the last is zero.
//
// Sums are made block by block, then in the order of the blocks, so that their bits do not depend on the threads.
#pragma once

#include <numeric>

#include "cpu/grid/grid.hpp"
#include "threads.hpp"

namespace neve {

template <class T>
class NodeField {
 public:
  void resize(std::size_t blocks) {
    if (blocks * block_values > data_.size()) data_.resize(blocks * block_values);
  }
  T* block(std::size_t b) { return data_.data() + b * block_values; }
  const T* block(std::size_t b) const { return data_.data() + b * block_values; }
  T* node(std::size_t b, int n) { return block(b) + 4 * n; }
  const T* node(std::size_t b, int n) const { return block(b) + 4 * n; }

 private:
  Column<T> data_;
};

namespace detail {

// The sum of f(i) over the numbers of a block, in double.
template <class F>
NEVE_INLINE double block_sum(F&& f) {
  double part[8] = {};
  for (int i = 0; i < block_values; i += 8) {
    for (int k = 0; k < 8; ++k) part[k] += f(i + k);
  }
  return ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7]));
}

}  // namespace detail

// f(b) for each block.
template <class F>
void each_block(std::size_t blocks, F&& f) {
#if defined(_OPENMP)
#pragma omp parallel for schedule(static)
#endif
  for (std::int64_t b = 0; b < static_cast<std::int64_t>(blocks); ++b) f(static_cast<std::size_t>(b));
}

// Sums over the blocks.
using BlockSums = std::vector<double>;
template <class F>
double each_block_summed(BlockSums& parts, std::size_t blocks, F&& f) {
  parts.resize(blocks);
  each_block(blocks, [&](std::size_t b) { parts[b] = f(b); });
  return std::accumulate(parts.begin(), parts.end(), 0.0);
}

// u . w, summed over the numbers of each block into `parts`.
template <class T>
double sum_products(const NodeField<T>& u, const NodeField<T>& w, std::size_t blocks, BlockSums& parts) {
  return each_block_summed(parts, blocks, [&](std::size_t b) {
    const T *a = u.block(b), *c = w.block(b);
    return detail::block_sum([&](int i) { return double(a[i]) * double(c[i]); });
  });
}
// The same of r d r, d the numbers of a diagonal.
template <class T>
void sum_squares(const NodeField<T>& r, const NodeField<T>& d, std::size_t blocks, BlockSums& parts) {
  each_block_summed(parts, blocks, [&](std::size_t b) {
    const T *a = r.block(b), *k = d.block(b);
    return detail::block_sum([&](int i) { return double(a[i]) * double(a[i]) * double(k[i]); });
  });
}

// The pieces of snow that share no node: whether a solve is good enough is asked of each, so that a small one that falls
// beside a large one that rests is solved for as well.
class Pieces {
 public:
  // `joined`: pairs of blocks that are of one piece besides.
  template <class T>
  void find(const Grid<T>& grid, const std::vector<std::pair<std::int32_t, std::int32_t>>& joined) {
    of_.resize(grid.blocks.size());
    std::iota(of_.begin(), of_.end(), 0);
    for (std::size_t h = 0; h < grid.moving; ++h) {
      for (std::int32_t b : grid.homes[h].nodes) join(grid.homes[h].nodes[0], b);
    }
    for (const auto& [a, b] : joined) join(a, b);
    count_ = 0;
    for (std::size_t b = 0; b < of_.size(); ++b)  // a root is the first block of its piece
      of_[b] = of_[b] == static_cast<std::int32_t>(b) ? count_++ : of_[static_cast<std::size_t>(of_[b])];
  }
  std::size_t count() const { return static_cast<std::size_t>(count_); }
  std::size_t of(std::size_t block) const { return static_cast<std::size_t>(of_[block]); }
  std::vector<double> sums(const BlockSums& parts) const {
    std::vector<double> out(count());
    for (std::size_t b = 0; b < parts.size(); ++b) out[of(b)] += parts[b];
    return out;
  }

 private:
  std::int32_t root(std::int32_t b) {
    while (of_[static_cast<std::size_t>(b)] != b) {
      std::int32_t& up = of_[static_cast<std::size_t>(b)];
      up = of_[static_cast<std::size_t>(up)];
      b = up;
    }
    return b;
  }
  void join(std::int32_t a, std::int32_t b) {
    a = root(a), b = root(b);
    of_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::vector<std::int32_t> of_;
  std::int32_t count_ = 0;
};

}  // namespace neve
