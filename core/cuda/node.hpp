// One node of a block, by a thread of its own: its values from memory and back, and the solids near its block.
#pragma once

#include "cuda/choices.hpp"
#include "cuda/grid/reduce.hpp"
#include "cuda/pace.hpp"
#include "cuda/solids.hpp"
#include "mpm/node_update.hpp"

namespace neve::cuda {

// The thread's node of a block. While solids act, `node` holds (v, m).
template <class C>
struct Node {
  using T = typename C::T;
  const Step<T>& s;
  StepConstants<T> step;
  std::size_t block, i;

  Node(const Step<T>& all, std::size_t b)
      : s(all), step(constants_of(all)), block(b), i(b * block_nodes + threadIdx.x) {}

  // Whether it is here, and in no other domain, that what solids do to the block's nodes is summed.
  bool counts() const { return s.nodes.ghosts == nullptr || s.nodes.ghosts[block] == 0; }
  Vec3<T> v() const { return {s.nodes.node[i].x, s.nodes.node[i].y, s.nodes.node[i].z}; }
  T m() const { return s.nodes.node[i].w; }
  Vec3<T> change() const {
    if constexpr (C::has_change) return {s.nodes.change[i].x, s.nodes.change[i].y, s.nodes.change[i].z};
    return {};
  }
  NEVE_INLINE void store(const Vec3<T>& v, const Vec3<T>& change, T m) const {
    s.nodes.node[i] = {v.x, v.y, v.z, m};
    if constexpr (C::has_change) s.nodes.change[i] = {change.x, change.y, change.z, T(0)};
  }

  // How far the node's snow has left surfaces with play, from m s; none if there is no such surface.
  NEVE_INLINE Lift<T> lift(T m) const {
    Lift<T> out{{}, step.dt, T(play_cells * double(step.cells.dx))};
    if constexpr (C::has_play) {
      const Quad<T> ms = s.nodes.lift[i];
      out.s = Vec3<T>{ms.x, ms.y, ms.z} * (has_velocity(m) ? inverse_mass(m) : T(0));
    }
    return out;
  }
  NEVE_INLINE void store_lift(const Vec3<T>& gained) const {
    if constexpr (C::has_play) s.nodes.lift[i] = {gained.x, gained.y, gained.z, T(0)};
  }

  NEVE_INLINE Vec3<T> x() const {
    const BlockCoord at = s.nodes.at[block];
    const int n = int(threadIdx.x);
    const T dx = step.cells.dx;
    return {T(4 * at.x + n / 16) * dx, T(4 * at.y + n / 4 % 4) * dx, T(4 * at.z + n % 4) * dx};
  }
  // The solids near the block. All threads of the block must come.
  NearSolids<T> near(Marks& marks) const {
    mark_near(s, s.nodes.at[block], T(1.5), T(3.2), marks);
    return {s.solids, s.solid_count, marks};
  }

  // Write the bounds of the block; nodes lighter than a thousandth of the lightest particle are left out. All threads of
  // the block must come.
  NEVE_INLINE void bound(const Vec3<T>& v, const Vec3<T>& change, T m) const {
    constexpr T far = std::numeric_limits<T>::max();
    T most[8] = {-far, -far, -far, -far, -far, -far, T(0), T(0)};
    if (m >= s.lightest * T(1e-3)) {
      for (int k = 0; k < 3; ++k) most[k] = v[k], most[3 + k] = -v[k];
      if constexpr (C::has_change) most[6] = max(abs(change.x), max(abs(change.y), abs(change.z)));
    }
    const T odd = (v.x - v.x) + (v.y - v.y) + (v.z - v.z) + (m - m);
    most[7] = odd == T(0) ? T(0) : T(1);
    block_max<block_nodes>(most);
    if (threadIdx.x == 0) {
      s.nodes.bounds[block] = {
          {-most[3], -most[4], -most[5]}, {most[0], most[1], most[2]}, most[6], most[7] == T(0)};
    }
  }
};

}  // namespace neve::cuda
