// A tree of boxes over triangles: split where the surface area heuristic says, the same tree for the same triangles. Few
// triangles as wide as all together, a rim of slivers round a terrain or a floor below it, are split off first: they would
// widen the box of each part that a split by place leaves them in.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "geometry/triangle.hpp"

namespace neve {

// The smallest box around points.
struct Bounds {
  static constexpr double inf = std::numeric_limits<double>::infinity();
  Point low{inf, inf, inf}, high{-inf, -inf, -inf};

  void add(const Point& p) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
  void add(const Bounds& o) { add(o.low), add(o.high); }
  double half_area() const {
    const Point d = high - low;
    return d.x >= 0 ? d.x * d.y + d.y * d.z + d.z * d.x : 0.0;
  }
  Point middle() const { return (low + high) * 0.5; }
  double length(int axis) const { return high[axis] - low[axis]; }
  // How far p is from the box; zero inside.
  double distance(const Point& p) const {
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = std::max({low[k] - p[k], p[k] - high[k], 0.0});
      d2 += d * d;
    }
    return std::sqrt(d2);
  }
};

// A node and, if it is no leaf, all below its left child right after it; half a cache line.
struct BvhNode {
  float low[3];         // rounded outwards
  std::uint32_t first;  // leaf: its first triangle; otherwise the right child
  float high[3];
  std::uint32_t count;  // triangles of a leaf; 0: no leaf

  bool leaf() const { return count > 0; }
  double distance2(const Point& p) const {
    double d2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = std::max({low[k] - p[k], p[k] - high[k], 0.0});
      d2 += d * d;
    }
    return d2;
  }
};

class BvhBuilder {
 public:
  static constexpr std::uint32_t leaf_most = 4;
  static constexpr int deepest =
      96;  // `by_area` levels, then halves of at most 2^32 triangles; and some room

  // most: boxes of a leaf.
  explicit BvhBuilder(const std::vector<Bounds>& boxes, std::uint32_t most = leaf_most)
      : boxes_(boxes), most_(most), order(boxes.size()) {
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    nodes.reserve(boxes.size());
    if (!boxes.empty()) build(0, std::uint32_t(boxes.size()), 0);
  }

 private:
  static constexpr int bins = 16;
  static constexpr int by_area = 40;       // levels that are split by area; below, in halves
  static constexpr double wide = 0.25;     // share of a box's side from which a triangle is wide
  static constexpr std::uint32_t few = 8;  // wide ones are split off if they are at most one of so many
  // What goes left: triangles of the bins up to `bin`; or, if `longer` is not negative, those longer than that.
  struct Split {
    int axis = -1, bin = 0;
    double longer = -1;
    double cost = Bounds::inf;
  };
  // Into which bin of the centres' range a triangle falls.
  struct Binning {
    Bounds centres;
    int operator()(const Point& centre, int axis) const {
      const double width = centres.high[axis] - centres.low[axis];
      return std::min(bins - 1, int((centre[axis] - centres.low[axis]) / width * bins));
    }
  };

  void build(std::uint32_t first, std::uint32_t count, int depth) {
    const std::size_t self = nodes.size();
    Bounds box;
    Binning bin;
    for (std::uint32_t i = first; i < first + count; ++i) {
      box.add(boxes_[order[i]]);
      bin.centres.add(boxes_[order[i]].middle());
    }
    nodes.push_back(node_of(box));
    if (count <= most_) {
      nodes[self].first = first, nodes[self].count = count;
      return;
    }
    const auto begin = order.begin() + first, end = begin + count;
    Split split;
    if (depth < by_area) {
      split = best_split(first, count, bin);
      const Split off = wide_off(first, count, box);
      if (off.cost < split.cost) split = off;
    }
    auto middle = begin + count / 2;
    if (split.axis >= 0) {
      middle = std::stable_partition(begin, end, [&](std::uint32_t i) {
        return split.longer < 0 ? bin(boxes_[i].middle(), split.axis) <= split.bin
                                : boxes_[i].length(split.axis) > split.longer;
      });
    }
    const auto left = std::uint32_t(middle - begin);
    build(first, left, depth + 1);
    nodes[self].first = std::uint32_t(nodes.size());
    build(first + left, count - left, depth + 1);
  }

  // The split with the least area times triangles; none if all centres are one point.
  Split best_split(std::uint32_t first, std::uint32_t count, const Binning& bin) const {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(bin.centres.high[axis] > bin.centres.low[axis])) continue;
      std::array<Bounds, bins> box;
      std::array<std::uint32_t, bins> held{};
      for (std::uint32_t i = first; i < first + count; ++i) {
        const Bounds& b = boxes_[order[i]];
        const auto at = std::size_t(bin(b.middle(), axis));
        box[at].add(b), ++held[at];
      }
      std::array<double, bins> right{};
      Bounds sum;
      std::uint32_t n = 0;
      for (std::size_t k = bins - 1; k > 0; --k) {
        sum.add(box[k]), n += held[k];
        right[k] = n > 0 ? sum.half_area() * n : Bounds::inf;
      }
      sum = {}, n = 0;
      for (std::size_t k = 0; k + 1 < bins; ++k) {
        sum.add(box[k]), n += held[k];
        const double cost = n > 0 ? sum.half_area() * n + right[k + 1] : Bounds::inf;
        if (cost < best.cost) best = {axis, int(k), -1, cost};
      }
    }
    return best;
  }

  // The best split of triangles that are wide along an axis from all others; none if there are none, or too many.
  Split wide_off(std::uint32_t first, std::uint32_t count, const Bounds& box) const {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      const double longer = wide * box.length(axis);
      Bounds off, rest;
      std::uint32_t n = 0;
      for (std::uint32_t i = first; i < first + count; ++i) {
        const Bounds& b = boxes_[order[i]];
        const bool is_wide = b.length(axis) > longer;
        n += is_wide, (is_wide ? off : rest).add(b);
      }
      if (n == 0 || n > count / few) continue;
      const double cost = off.half_area() * n + rest.half_area() * (count - n);
      if (cost < best.cost) best = {axis, 0, longer, cost};
    }
    return best;
  }

  static BvhNode node_of(const Bounds& box) {
    BvhNode node{};
    constexpr float inf = std::numeric_limits<float>::infinity();
    for (int k = 0; k < 3; ++k) {
      node.low[k] = std::nextafter(float(box.low[k]), -inf);
      node.high[k] = std::nextafter(float(box.high[k]), inf);
    }
    return node;
  }

  const std::vector<Bounds>& boxes_;
  std::uint32_t most_;

 public:
  std::vector<std::uint32_t> order;  // triangles as the leaves hold them
  std::vector<BvhNode> nodes;
};

}  // namespace neve
