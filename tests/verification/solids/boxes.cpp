// For test_tree_of_boxes.py: the tree of boxes over triangles, and how many of its boxes a line meets.
#include "geometry/bvh.hpp"

namespace neve::probe {

// Whether the line x + t d passes through a box.
inline bool passes(const BvhNode& node, const double* x, const double* d) {
  double first = -Bounds::inf, last = Bounds::inf;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (x[k] < node.low[k] || x[k] > node.high[k]) return false;
      continue;
    }
    const double a = (node.low[k] - x[k]) / d[k], b = (node.high[k] - x[k]) / d[k];
    first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
  }
  return first <= last;
}

// Call visit(node, depth) for each node from the root down, and go on below it if that returns true.
template <class Visit>
void descend(const BvhBuilder& tree, const Visit& visit) {
  std::vector<std::pair<std::uint32_t, int>> waiting{{0, 0}};
  while (!waiting.empty()) {
    const auto [n, depth] = waiting.back();
    waiting.pop_back();
    const BvhNode& node = tree.nodes[n];
    if (!visit(node, depth) || node.leaf()) continue;
    waiting.emplace_back(n + 1, depth + 1);
    waiting.emplace_back(node.first, depth + 1);
  }
}

}  // namespace neve::probe

extern "C" {
// Of n triangles (n, 3, 3) and `lines` lines (lines, 2, 3), point and direction: how many boxes each is held against.
// Returns how deep the deepest leaf lies, or -1 if the leaves do not hold each triangle once, within their box.
int boxes_met(int n, const double* corners, int lines, const double* line, int* met) {
  using namespace neve;
  std::vector<Bounds> boxes(static_cast<std::size_t>(n));
  for (int i = 0; i < 3 * n; ++i)
    boxes[std::size_t(i / 3)].add(Point{corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]});
  const BvhBuilder tree(boxes);
  int deepest = 0;
  bool right = true;
  std::vector<int> held(boxes.size());
  probe::descend(tree, [&](const BvhNode& node, int depth) {
    deepest = std::max(deepest, depth);
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Bounds& box = boxes[tree.order[i]];
      ++held[tree.order[i]];
      for (int k = 0; k < 3; ++k) right = right && node.low[k] <= box.low[k] && box.high[k] <= node.high[k];
    }
    return true;
  });
  for (int times : held) right = right && times == 1;
  for (int l = 0; l < lines; ++l) {
    met[l] = 0;
    probe::descend(tree, [&](const BvhNode& node, int) {
      ++met[l];
      return probe::passes(node, line + 6 * l, line + 6 * l + 3);
    });
  }
  return right ? deepest : -1;
}
}
