// The solids near a block, and what the snow does to them.
#pragma once

#include "coupling/contacts.hpp"
#include "cuda/choices.hpp"
#include "cuda/grid/views.hpp"

namespace neve::cuda {

// Of so many solids a block marks which are near; later ones always count as near.
inline constexpr unsigned most_marked = 1024;
struct Marks {
  unsigned word[most_marked / 32];
};

// A range of Solid<T>: those that are marked, in the order of the scene.
template <class T>
struct NearSolids {
  const Solid<T>* all;
  unsigned count;
  const Marks& marks;

  struct Iterator {
    const NearSolids& of;
    unsigned at;
    const Solid<T>& operator*() const { return of.all[at]; }
    Iterator& operator++() {
      at = of.next(at + 1);
      return *this;
    }
    bool operator!=(const Iterator& o) const { return at != o.at; }
  };
  unsigned next(unsigned i) const {
    while (i < count && i < most_marked) {
      const unsigned rest = marks.word[i / 32] >> (i % 32);
      if (rest != 0) return min(i + unsigned(__ffs(int(rest))) - 1, count);
      i = (i / 32 + 1) * 32;
    }
    return min(i, count);
  }
  Iterator begin() const { return {*this, next(0)}; }
  Iterator end() const { return {*this, count}; }
  bool empty() const { return next(0) == count; }
};

// Mark the solids whose surface may lie within `reach` [cells] of the point that lies `half` [cells] from a block's first
// node along each axis. All threads of the block must come; a barrier is at the end.
template <class T>
inline void mark_near(const Step<T>& s, const BlockCoord& at, T half, T reach, Marks& marks) {
  const T dx = s.constants.step.cells.dx;
  const Vec3<T> middle{(T(4 * at.x) + half) * dx, (T(4 * at.y) + half) * dx, (T(4 * at.z) + half) * dx};
  for (unsigned k = threadIdx.x; k < most_marked / 32; k += blockDim.x) marks.word[k] = 0;
  __syncthreads();
  for (unsigned i = threadIdx.x; i < min(s.solid_count, most_marked); i += blockDim.x) {
    if (is_near(s.solids[i], middle, reach * dx)) atomicOr(&marks.word[i / 32], 1u << (i % 32));
  }
  __syncthreads();
}

// What a block has exchanged with the first few solids is summed in shared memory, so that the sums of a floor, which
// many touch, meet once a block in memory. N: a Sum.
inline constexpr int summed_solids = 4, exchange_numbers = 7;
static_assert(sizeof(Exchange) == exchange_numbers * sizeof(double));

template <class N>
struct BlockExchange {
  N sum[summed_solids][exchange_numbers];

  // Each thread of a block does its share; a barrier must follow.
  void clear() {
    for (unsigned k = threadIdx.x; k < summed_solids * exchange_numbers; k += blockDim.x)
      sum[k / exchange_numbers][k % exchange_numbers].clear();
  }
  // Hand the sums over; a barrier must come before.
  void publish(N* to, unsigned solids) const {
    for (unsigned k = threadIdx.x; k < min(solids, unsigned(summed_solids)) * exchange_numbers;
         k += blockDim.x)
      to[k].add(sum[k / exchange_numbers][k % exchange_numbers]);
  }
};

template <class N>
inline void add_exchange(N* to, const Exchange& e) {
  for (int k = 0; k < 3; ++k) to[k].add(e.impulse[k]), to[3 + k].add(e.moment[k]);
  to[6].add(e.work);
}

// Called with what a solid did to a mass m.
template <class T, class N>
struct Recorder {
  BlockExchange<N>& sums;
  N* exchanged;
  T m;
  bool counts;  // else it is a trial

  void operator()(const Solid<T>& solid, bool met, const Vec3<T>& arm, const Vec3<T>& v_co,
                  const Vec3<T>& before, const Vec3<T>& after) const {
    if (!met || !counts) return;
    Exchange e;
    record(e, met, m, arm, v_co, before, after);
    const int i = solid.index;
    add_exchange(i < summed_solids ? sums.sum[i] : exchanged + i * exchange_numbers, e);
  }
};
template <class C>
inline typename C::Number* exchanged_of(const Step<typename C::T>& s) {
  return static_cast<typename C::Number*>(s.exchanged);
}

// No solids at all.
template <class T>
struct NoSolids {
  const Solid<T>* begin() const { return nullptr; }
  const Solid<T>* end() const { return nullptr; }
};

}  // namespace neve::cuda
