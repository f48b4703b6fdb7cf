// One level of a sparse scalar grid: blocks of 4x4x4 cells, found through a hash table. Memory follows the
// occupied blocks, so one flake ten kilometres away costs one block.
#pragma once

#include <numeric>
#include <span>
#include <vector>

#include "math/bspline.hpp"
#include "render/view/vec.hpp"
#include "threads.hpp"

namespace neve::render {

struct Int3 {
  std::int32_t x = 0, y = 0, z = 0;
  bool operator==(const Int3&) const = default;
};

class Blocks {
 public:
  static constexpr int side = 4, shift = 2, mask = side - 1;
  // Each block has room for the first two cells of the blocks after it: a quadratic stencil that begins in
  // a block writes into that block only, and a trilinear sample reads from that block only.
  static constexpr int stride = side + 2;
  static constexpr int cells = stride * stride * stride;
  // From block to block: rows are written four cells at a time, the last of them past the end.
  static constexpr int pitch = cells + 8;

  explicit Blocks(float cell_size) : h_(cell_size), inv_h_(1.0f / cell_size), table_(64, Slot{{}, -1}) {}

  float cell_size() const { return h_; }
  int count() const { return int(where_.size()); }
  Int3 where(int block) const { return where_[std::size_t(block)]; }
  float* values(int block) { return values_.data() + std::size_t(block) * pitch; }
  const float* values(int block) const { return values_.data() + std::size_t(block) * pitch; }
  static int at(int i, int j, int k) { return (i * stride + j) * stride + k; }
  Vec3f low() const { return low_; }
  Vec3f high() const { return high_; }

  // Return the index of the block at `b`, or -1.
  int find(Int3 b) const {
    if (!box_.empty()) {
      const std::uint32_t i = std::uint32_t(b.x) - std::uint32_t(first_.x),
                          j = std::uint32_t(b.y) - std::uint32_t(first_.y),
                          k = std::uint32_t(b.z) - std::uint32_t(first_.z);
      const bool in_box = i < size_[0] && j < size_[1] && k < size_[2];
      return in_box ? box_[(std::size_t(i) * size_[1] + j) * size_[2] + k] : -1;
    }
    const std::uint32_t last = std::uint32_t(table_.size() - 1);
    for (std::uint32_t slot = hash(b) & last;; slot = (slot + 1) & last) {
      const Slot& s = table_[slot];
      if (s.block < 0 || s.key == b) return s.block;
    }
  }

  // Return the index of the block at `b`, made of zeros if it was not there.
  int require(Int3 b) {
    const int found = find(b);
    if (found >= 0) return found;
    box_.clear();
    if (2 * (where_.size() + 1) > table_.size()) grow();
    const int block = count();
    where_.push_back(b);
    values_.resize(values_.size() + pitch, 0.0f);
    insert(b, block);
    return block;
  }

  // Hand what stencils wrote past the end of their block on to the blocks where it belongs, in block order.
  void fold() {
    for (int b = 0, n = count(); b < n; ++b)
      for (int sides = 1; sides < 8; ++sides) fold_side(b, sides);
  }

  // Return the same blocks, full of zeros.
  Blocks zeros() const {
    Blocks out = *this;
    std::fill(out.values_.begin(), out.values_.end(), 0.0f);
    return out;
  }

  // Make the grid ready for samples: add the empty blocks that a sample next to an occupied one reads,
  // copy the shared cells, and find the bounds.
  void close() {
    add_borders();
    box_blocks();
    const int n = count();
#pragma omp parallel for schedule(static)
    for (int b = 0; b < n; ++b) copy_border(b);
    low_ = {1e30f, 1e30f, 1e30f};
    high_ = {-1e30f, -1e30f, -1e30f};
    for (const Int3& b : where_) {  // the sample points of block b, in metres
      const Vec3f corner = Vec3f{float(b.x), float(b.y), float(b.z)} * (side * h_) + Vec3f{h_, h_, h_} * 0.5f;
      low_ = {std::min(low_.x, corner.x), std::min(low_.y, corner.y), std::min(low_.z, corner.z)};
      const Vec3f end = corner + Vec3f{h_, h_, h_} * side;
      high_ = {std::max(high_.x, end.x), std::max(high_.y, end.y), std::max(high_.z, end.z)};
    }
  }

  // Interpolate between cell centres at the point p [m]; zero where there is no block.
  float sample(Vec3f p) const {
    if (!inside(p)) return 0.0f;
    const Vec3f q = cell_of(p);
    const float fi = std::floor(q.x), fj = std::floor(q.y), fk = std::floor(q.z);
    const std::int32_t i = std::int32_t(fi), j = std::int32_t(fj), k = std::int32_t(fk);
    const int block = find({i >> shift, j >> shift, k >> shift});
    if (block < 0) return 0.0f;
    const float* v = values(block) + at(i & mask, j & mask, k & mask);
    const float a = q.x - fi, b = q.y - fj, c = q.z - fk;
    constexpr int di = stride * stride, dj = stride;
    const float v00 = mix(v[0], v[1], c), v01 = mix(v[dj], v[dj + 1], c);
    const float v10 = mix(v[di], v[di + 1], c), v11 = mix(v[di + dj], v[di + dj + 1], c);
    return mix(mix(v00, v01, b), mix(v10, v11, b), a);
  }

  // Return the index of the block that a sample at p reads, or -1. cell: number of the cell in it, from 0 to side^3 - 1
  int holding(Vec3f p, int& cell) const {
    if (!inside(p)) return -1;
    const Vec3f q = cell_of(p);
    const std::int32_t i = std::int32_t(std::floor(q.x)), j = std::int32_t(std::floor(q.y)),
                       k = std::int32_t(std::floor(q.z));
    cell = ((i & mask) * side + (j & mask)) * side + (k & mask);
    return find({i >> shift, j >> shift, k >> shift});
  }
  int holding(Vec3f p) const {
    int cell;
    return holding(p, cell);
  }

  // Say whether samples around p can be anything but zero.
  bool occupied(Vec3f p) const { return holding(p) >= 0; }

  // Narrow [near, far], lengths [m] from p along the unit vector `dir`, to the bounds of all blocks.
  void clip(Vec3f p, Vec3f dir, float& near, float& far) const {
    clip_axis(p.x, dir.x, low_.x, high_.x, near, far);
    clip_axis(p.y, dir.y, low_.y, high_.y, near, far);
    clip_axis(p.z, dir.z, low_.z, high_.z, near, far);
  }

  // Length [m] from p along the unit vector `dir` to the end of the block around p.
  float exit(Vec3f p, Vec3f dir) const {
    const Vec3f q = cell_of(p);
    return std::min({exit_axis(q.x, dir.x), exit_axis(q.y, dir.y), exit_axis(q.z, dir.z)}) * h_;
  }

 private:
  struct Slot {
    Int3 key;
    std::int32_t block;
  };

  static std::uint32_t hash(Int3 b) {
    const std::uint32_t a =
        std::uint32_t(b.x) * 73856093u ^ std::uint32_t(b.y) * 19349663u ^ std::uint32_t(b.z) * 83492791u;
    return a ^ a >> 15;
  }
  Vec3f cell_of(Vec3f p) const { return {p.x * inv_h_ - 0.5f, p.y * inv_h_ - 0.5f, p.z * inv_h_ - 0.5f}; }
  bool inside(Vec3f p) const {
    return p.x >= low_.x && p.y >= low_.y && p.z >= low_.z && p.x < high_.x && p.y < high_.y && p.z < high_.z;
  }
  static void clip_axis(float p, float d, float low, float high, float& near, float& far) {
    const float inv = 1.0f / (std::abs(d) > 1e-12f ? d : std::copysign(1e-12f, d));
    const float a = (low - p) * inv, b = (high - p) * inv;
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  static float exit_axis(float q, float d) {
    if (std::abs(d) < 1e-6f) return 1e30f;
    const float block = std::floor(q / side);
    return ((d > 0 ? block + 1 : block) * side - q) / d;
  }
  void insert(Int3 b, int block) {
    const std::uint32_t last = std::uint32_t(table_.size() - 1);
    std::uint32_t slot = hash(b) & last;
    while (table_[slot].block >= 0) slot = (slot + 1) & last;
    table_[slot] = {b, block};
  }
  void grow() {
    table_.assign(table_.size() * 2, Slot{{}, -1});
    for (int b = 0; b < count(); ++b) insert(where_[std::size_t(b)], b);
  }

  // Number the places of the box around all blocks, where they fill enough of it: that is found faster.
  void box_blocks() {
    constexpr double most = 64;  // places for each block
    Int3 low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
    for (const Int3& b : where_) {
      low = {std::min(low.x, b.x), std::min(low.y, b.y), std::min(low.z, b.z)};
      high = {std::max(high.x, b.x), std::max(high.y, b.y), std::max(high.z, b.z)};
    }
    const double places =
        (double(high.x) - low.x + 1) * (double(high.y) - low.y + 1) * (double(high.z) - low.z + 1);
    if (where_.empty() || places > most * double(where_.size())) return;
    first_ = low;
    size_[0] = std::uint32_t(high.x - low.x + 1), size_[1] = std::uint32_t(high.y - low.y + 1),
    size_[2] = std::uint32_t(high.z - low.z + 1);
    std::vector<std::int32_t> box(std::size_t(places), -1);
    for (int b = 0; b < count(); ++b) {
      const Int3 at = where(b);
      const std::size_t i = std::size_t(at.x - low.x), j = std::size_t(at.y - low.y),
                        k = std::size_t(at.z - low.z);
      box[(i * size_[1] + j) * size_[2] + k] = b;
    }
    box_ = std::move(box);
  }

  // A side of a block is three bits: which of its x, y, z lie past the block.
  static Int3 step(int sides) { return {sides & 1, sides >> 1 & 1, sides >> 2}; }
  static int end(int bit, int ends) { return bit ? ends : side; }

  void fold_side(int block, int sides) {
    const Int3 d = step(sides), w = where(block);
    const auto each = [&](auto&& visit) {
      for (int i = d.x * side; i < end(d.x, stride); ++i)
        for (int j = d.y * side; j < end(d.y, stride); ++j)
          for (int k = d.z * side; k < end(d.z, stride); ++k)
            visit(at(i, j, k), at(i & mask, j & mask, k & mask));
    };
    bool any = false;
    const float* found = values(block);
    each([&](int c, int) { any |= found[c] != 0.0f; });
    if (!any) return;
    const int next = require({w.x + d.x, w.y + d.y, w.z + d.z});
    float *from = values(block), *to = values(next);
    each([&](int c, int there) { to[there] += from[c], from[c] = 0.0f; });
  }
  // A sample just before an occupied block reads that block's first cells: it needs a block to read them
  // from.
  void add_borders() {
    for (int b = 0, n = count(); b < n; ++b)
      for (int sides = 1; sides < 8; ++sides) {
        const Int3 d = step(sides), w = where(b);
        if (first_cells_occupied(b, d)) require({w.x - d.x, w.y - d.y, w.z - d.z});
      }
  }
  bool first_cells_occupied(int block, Int3 d) const {
    const float* v = values(block);
    for (int i = 0; i < end(d.x, 1); ++i)
      for (int j = 0; j < end(d.y, 1); ++j)
        for (int k = 0; k < end(d.z, 1); ++k)
          if (v[at(i, j, k)] != 0.0f) return true;
    return false;
  }
  void copy_border(int block) {
    const Int3 w = where(block);
    for (int sides = 1; sides < 8; ++sides) {
      const Int3 d = step(sides);
      const int next = find({w.x + d.x, w.y + d.y, w.z + d.z});
      if (next < 0) continue;
      for (int i = 0; i < end(d.x, 1); ++i)
        for (int j = 0; j < end(d.y, 1); ++j)
          for (int k = 0; k < end(d.z, 1); ++k)
            values(block)[at(i + d.x * side, j + d.y * side, k + d.z * side)] = values(next)[at(i, j, k)];
    }
  }

  float h_, inv_h_;
  std::vector<Slot> table_;
  std::vector<std::int32_t> box_;  // blocks by place in the box around all; empty if that is not known
  Int3 first_;                     // of the box
  std::uint32_t size_[3] = {};     // of the box
  std::vector<Int3> where_;
  std::vector<float> values_;
  Vec3f low_{}, high_{};
};

// One axis of a quadratic B-spline: the first of three cells and their weights.
struct Stencil {
  std::int32_t first;
  float w[Quadratic::nodes];

  // q: position in cells, cell centres at i + 1/2
  explicit Stencil(float q) : first(begin(q)) {
    float slopes[Quadratic::nodes];
    Quadratic::weights(q - std::floor(q), w, slopes);
  }
  static std::int32_t begin(float q) { return std::int32_t(std::floor(q)) - 1; }
};

inline void add_point(float* block, Vec3f q, float amount) {
  const Stencil sx(q.x), sy(q.y), sz(q.z);
  const float w[4] = {sz.w[0], sz.w[1], sz.w[2], 0.0f};
  float* v = block + Blocks::at(sx.first & Blocks::mask, sy.first & Blocks::mask, sz.first & Blocks::mask);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const float row = amount * sx.w[a] * sy.w[b];
      float* to = v + Blocks::at(a, b, 0);
      for (int c = 0; c < 4; ++c) to[c] += row * w[c];
    }
}

// The block in which the stencil of each point begins; -1: none, for a point that is not finite or too far away.
using BlockOf = std::vector<std::int32_t>;

// Find the blocks of the points x [m], which are made where there are none. count: how many points each then has.
inline BlockOf blocks_of(Blocks& blocks, std::span<const Vec3f> x, std::vector<std::uint32_t>& count) {
  // Cells are numbered with 32 bits; a point beyond this many cells is left out.
  constexpr float far_cell = 1.0e9f;
  const float inv_h = 1.0f / blocks.cell_size();
  BlockOf home(x.size(), -1);
  Int3 last{INT32_MAX, 0, 0};
  int block = -1;
  for (std::size_t p = 0; p < x.size(); ++p) {
    const Vec3f q = x[p] * inv_h;
    if (!(std::abs(q.x) < far_cell && std::abs(q.y) < far_cell && std::abs(q.z) < far_cell)) continue;
    const Int3 at{Stencil::begin(q.x) >> Blocks::shift, Stencil::begin(q.y) >> Blocks::shift,
                  Stencil::begin(q.z) >> Blocks::shift};
    if (!(at == last)) {
      block = blocks.require(at);
      count.resize(std::size_t(blocks.count()), 0);
    }
    last = at;
    home[p] = block;
    ++count[std::size_t(block)];
  }
  return home;
}

// Points by the block in which their stencil begins: those of block b are order[first[b]] to order[first[b + 1] - 1].
struct Groups {
  std::vector<std::uint32_t> first, order;
  int blocks() const { return int(first.size()) - 1; }
};

// Group the points x [m] by their blocks.
inline Groups grouped(Blocks& blocks, std::span<const Vec3f> x) {
  std::vector<std::uint32_t> first;
  const BlockOf home = blocks_of(blocks, x, first);
  first.insert(first.begin(), 0);
  for (std::size_t b = 1; b < first.size(); ++b) first[b] += first[b - 1];
  std::vector<std::uint32_t> order(first.back()), next(first);
  for (std::uint32_t p = 0; p < x.size(); ++p)
    if (home[p] >= 0) order[next[std::size_t(home[p])]++] = p;
  return {std::move(first), std::move(order)};
}

// Call f(b, p) for each point p of each block b of `groups`, in order within a block.
template <class F>
void each_point(const Groups& groups, F&& f) {
  const int n = groups.blocks();
#pragma omp parallel for schedule(dynamic, 64)
  for (int b = 0; b < n; ++b)
    for (std::uint32_t o = groups.first[std::size_t(b)]; o < groups.first[std::size_t(b) + 1]; ++o)
      f(b, groups.order[o]);
}

// Cut blocks with so many points each into `parts` of about as many points: part s is [first[s], first[s + 1]).
inline std::vector<std::int32_t> shares(std::span<const std::uint32_t> count, int parts) {
  const std::uint64_t all = std::accumulate(count.begin(), count.end(), std::uint64_t(0));
  std::vector<std::int32_t> first{0};
  std::uint64_t sum = 0;
  for (std::size_t b = 0; b < count.size(); ++b) {
    sum += count[b];
    while (int(first.size()) < parts && sum * std::uint64_t(parts) >= all * first.size())
      first.push_back(std::int32_t(b) + 1);
  }
  first.resize(std::size_t(parts), std::int32_t(count.size()));
  first.push_back(std::int32_t(count.size()));
  return first;
}

// Spread an amount of each point over the cells around it with quadratic B-splines, whose weights sum to one, and return
// the blocks of the points. x: positions [m]; amount(p): of point p. Each thread goes through all points and adds those of its own blocks, so
// that the points of a block are added in their order.
template <class F>
BlockOf scatter(Blocks& blocks, std::span<const Vec3f> x, F&& amount) {
  const float inv_h = 1.0f / blocks.cell_size();
  std::vector<std::uint32_t> count;
  BlockOf home = blocks_of(blocks, x, count);
  const std::vector<std::int32_t> first = shares(count, thread_count());
  each_chunk(first.size() - 1, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s)
      for (std::size_t p = 0; p < x.size(); ++p)
        if (home[p] >= first[s] && home[p] < first[s + 1])
          add_point(blocks.values(home[p]), x[p] * inv_h, amount(p));
  });
  blocks.fold();
  return home;
}

}  // namespace neve::render
