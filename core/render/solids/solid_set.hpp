// The solids of a frame and a tree of boxes over them, so that a ray or a point asks only those that may matter to it.
// The tree leaves out what cannot matter and nothing else: a picture does not depend on it.
#pragma once

#include "geometry/bvh.hpp"
#include "render/solids/solids.hpp"

namespace neve::render {

class SolidSet {
 public:
  // eye: where the rays of `nearest` begin; leaf: solids in a leaf of the tree at most.
  explicit SolidSet(Vec3f eye, std::uint32_t leaf = BvhBuilder::leaf_most) : eye_(eye), leaf_(leaf) {}

  const std::vector<Solid>& solids() const { return solids_; }

  void assign(const std::vector<Solid>& solids) {
    solids_ = solids;
    order_.clear(), endless_.clear();
    count_[0] = count_[1] = 0;
    for (std::uint32_t b = 0; b < solids_.size(); ++b) {
      ++count_[solids_[b].is_static];
      const Vec3f& at = solids_[b].middle;
      const bool bounded = solids_[b].bound + std::abs(at.x) + std::abs(at.y) + std::abs(at.z) < 1e20f;
      (bounded ? order_ : endless_).push_back(b);
    }
    std::vector<Bounds> boxes;
    boxes.reserve(order_.size());
    for (std::uint32_t b : order_) boxes.push_back(box_of(solids_[b]));
    const BvhBuilder tree(boxes, leaf_);
    std::vector<std::uint32_t> order;
    order.reserve(order_.size());
    for (std::uint32_t i : tree.order) order.push_back(order_[i]);
    order_ = std::move(order);
    nodes_ = tree.nodes;
    balls_.assign(nodes_.size(), {});
    for (std::size_t n = nodes_.size(); n-- > 0;) balls_[n] = balls_of(std::uint32_t(n));
  }

  struct Nearest {
    int solid = -1;
    Hit hit;
  };
  // Meet what is nearest along a ray from the eye, of equals the first in the list. meshes: whether they count.
  Nearest nearest(Vec3f ray, bool meshes) const {
    Nearest found;
    const auto ask = [&](std::uint32_t b) {
      if (solids_[b].mesh && !meshes) return;
      const Hit hit = meet(solids_[b], eye_, ray);
      if (hit.t < found.hit.t || (hit.t == found.hit.t && int(b) < found.solid)) found = {int(b), hit};
    };
    for (std::uint32_t b : endless_) ask(b);
    Vec3f inverse;
    for (int k = 0; k < 3; ++k)
      inverse[k] = 1.0f / (std::abs(ray[k]) > 1e-18f ? ray[k] : std::copysign(1e-18f, ray[k]));
    struct Waiting {
      std::uint32_t node;
      float enters;
    } stack[BvhBuilder::deepest];
    int top = 0;
    if (!nodes_.empty()) stack[top++] = {0, 0.0f};
    while (top > 0) {
      const Waiting at = stack[--top];
      if (at.enters > found.hit.t) continue;
      const BvhNode& node = nodes_[at.node];
      if (node.leaf()) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) ask(order_[i]);
        continue;
      }
      Waiting near{at.node + 1, enters(nodes_[at.node + 1], inverse)},
          far{node.first, enters(nodes_[node.first], inverse)};
      if (far.enters < near.enters) std::swap(near, far);
      if (far.enters < out) stack[top++] = far;
      if (near.enters < out) stack[top++] = near;
    }
    return found;
  }

  // Call visit(solid) for those that may hide a part of the sun from p, in the order of the list, as long as it
  // returns true.
  template <class Visit>
  void each_toward_sun(Vec3f p, Vec3f sun, const Visit& visit) const {
    each(visit, [&](const Balls& balls) {
      const Vec3f to = balls.middle - p;
      const float square = dot(to, to), along = dot(to, sun), far = std::sqrt(square);
      const float slack = balls.spread + 2e-3f * far;
      if (along + slack < -balls.bound) return false;
      const float aside = std::sqrt(std::max(square - along * along, 0.0f));
      return aside - slack <= balls.bound * 1.1f + sun_angle * std::max(along + slack, 0.0f);
    });
  }
  // The same for those that may hide a part of the sky.
  template <class Visit>
  void each_around(Vec3f p, const Visit& visit) const {
    each(visit, [&](const Balls& balls) {
      const float far = length(p - balls.middle);
      return far - balls.spread - 1e-3f * far <= 2.5f * balls.bound;
    });
  }

  // Whether there is no solid that rests, or none that may move.
  bool none(bool is_static) const { return count_[is_static] == 0; }

 private:
  static constexpr float out = 1e30f;

  // Balls around solids: their middles lie in one around `middle` of radius `spread`.
  struct Balls {
    Vec3f middle{};
    float spread = 0, bound = 0;  // bound: the largest radius [m]
  };

  // The box around a solid, widened by what rounding may do to a ray from the eye that passes it.
  Bounds box_of(const Solid& solid) const {
    Vec3f half{solid.bound, solid.bound, solid.bound};
    const Vec3f size = solid.place.half;
    if (!solid.mesh && solid.place.kind != Shape::sphere) {
      const Vec3f edge = solid.place.kind == Shape::cylinder ? Vec3f{size.x, size.x, size.z} : size;
      const auto& r = solid.place.rotation;
      for (int k = 0; k < 3; ++k)
        half[k] = std::abs(r.c0[k]) * edge.x + std::abs(r.c1[k]) * edge.y + std::abs(r.c2[k]) * edge.z;
    }
    // A root in single precision misses the square of a distance by some units in its last place.
    const float far = length(solid.middle - eye_) + solid.bound;
    Bounds box;
    for (int k = 0; k < 3; ++k) {
      const double wide =
          std::sqrt(double(half[k]) * half[k] + 4e-6 * double(far) * far) + 1e-5 * double(far);
      box.low[k] = solid.middle[k] - wide, box.high[k] = solid.middle[k] + wide;
    }
    return box;
  }

  // Where the ray enters the node's box; more than `out` if it does not.
  float enters(const BvhNode& node, Vec3f inverse) const {
    float near = 0, far = out;
    for (int k = 0; k < 3; ++k) {
      const float a = (node.low[k] - eye_[k]) * inverse[k], b = (node.high[k] - eye_[k]) * inverse[k];
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    }
    return near > far * 1.00001f ? 2 * out : near;
  }

  // The balls of a node, whose children come after it.
  Balls balls_of(std::uint32_t n) const {
    const BvhNode& node = nodes_[n];
    Balls sum;
    Bounds middles;
    const auto box = [&](const Balls& b) {
      const Point m{b.middle.x, b.middle.y, b.middle.z}, s{b.spread, b.spread, b.spread};
      middles.add(m - s), middles.add(m + s);
      sum.bound = std::max(sum.bound, b.bound);
    };
    if (node.leaf()) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        box({solids_[order_[i]].middle, 0.0f, solids_[order_[i]].bound});
    } else {
      box(balls_[n + 1]), box(balls_[node.first]);
    }
    const Point middle = middles.middle(), half = middles.high - middle;
    sum.middle = {float(middle.x), float(middle.y), float(middle.z)};
    const double far = std::sqrt(dot(middle, middle));
    sum.spread = float(std::sqrt(dot(half, half)) * 1.00001 + 1e-6 * far);
    return sum;
  }

  template <class Visit, class May>
  void each(const Visit& visit, const May& may) const {
    thread_local std::vector<std::uint32_t> found;
    found.assign(endless_.begin(), endless_.end());
    std::uint32_t stack[BvhBuilder::deepest];
    int top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t n = stack[--top];
      if (!may(balls_[n])) continue;
      const BvhNode& node = nodes_[n];
      if (node.leaf())
        found.insert(found.end(), order_.begin() + node.first, order_.begin() + node.first + node.count);
      else
        stack[top++] = node.first, stack[top++] = n + 1;
    }
    std::sort(found.begin(), found.end());
    for (std::uint32_t b : found)
      if (!visit(solids_[b])) return;
  }

  Vec3f eye_;
  std::uint32_t leaf_;
  std::vector<Solid> solids_;
  std::vector<std::uint32_t> endless_;  // the others are in the tree
  std::vector<std::uint32_t> order_;    // as the leaves hold them
  std::vector<BvhNode> nodes_;
  std::vector<Balls> balls_;  // of the nodes
  std::size_t count_[2] = {0, 0};
};

}  // namespace neve::render
