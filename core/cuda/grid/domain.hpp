// One run on several devices, each with the particles of a domain of its own (Wang et al. 2020, static partition): whose a
// particle is, and the nodes that several domains have because homes on both sides of a border cover them.
#pragma once

#include "cuda/grid/sort.hpp"

namespace neve::cuda {

// The domain that owns a home.
inline unsigned owner_of(const Domain& d, const BlockCoord& home) {
  const int at = d.axis == 0 ? home.x : d.axis == 1 ? home.y : home.z;
  unsigned owner = 0;
  while (owner + 1 < d.domains && at >= d.cuts[owner]) ++owner;
  return owner;
}

// A thread per particle: the domain that it belongs to, and a number of its own among those that leave for the same one.
// Whoever has no home stays: the sort will tell of it.
template <class C>
inline void find_owners(const Step<typename C::T>& s) {
  const unsigned p = thread_number();
  if (p >= s.particle_count) return;
  BlockKey key;
  unsigned owner = s.domain.number;
  if (placing_of<C>(s).home(position(s, p), key)) owner = owner_of(s.domain, coord_of(key));
  s.sorting.home_of[p] = int(owner);
  if (owner != s.domain.number) s.sorting.place[p] = atomicAdd(&s.domain.counts[owner], 1u);
}

// A thread per particle: the order of the rows by domain, those that stay first. The next sort decides about the rest.
template <class T>
inline void part_particles(const Step<T>& s) {
  const unsigned p = thread_number();
  if (p >= s.particle_count) return;
  const unsigned owner = unsigned(s.sorting.home_of[p]);
  const unsigned place =
      owner != s.domain.number ? s.sorting.place[p] : atomicAdd(&s.domain.counts[owner], 1u);
  s.sorting.order[s.domain.begins[owner] + place] = p;
}

// f(where a node's numbers are, their place in the halo) for each kind of number: a block of threads per block of nodes.
template <class C, class F>
inline void each_shared_node(const Step<typename C::T>& s, F&& f) {
  const std::size_t node = std::size_t(s.halo.blocks[blockIdx.x]) * block_nodes + threadIdx.x;
  const std::size_t all = std::size_t(s.halo.count) * block_nodes;
  auto* value = s.halo.values + std::size_t(blockIdx.x) * block_nodes + threadIdx.x;
  f(s.nodes.node[node], *value);
  if constexpr (C::has_change) f(s.nodes.change[node], *(value += all));
  if constexpr (C::has_play) f(s.nodes.lift[node], *(value += all));
}

// What the nodes have, for another domain; with Meeting::take it is no longer here.
template <class C>
inline void pack_halo(const Step<typename C::T>& s) {
  using T = typename C::T;
  each_shared_node<C>(s, [&](Quad<T>& node, Quad<T>& value) {
    value = node;
    if (s.halo.meeting == int(Meeting::take)) node = Quad<T>{};
  });
}

// What another domain has: instead of what is here, or with Meeting::add beside it.
template <class C>
inline void unpack_halo(const Step<typename C::T>& s) {
  using T = typename C::T;
  each_shared_node<C>(s, [&](Quad<T>& node, Quad<T>& value) {
    if (s.halo.meeting == int(Meeting::add)) {
      node = {node.x + value.x, node.y + value.y, node.z + value.z, node.w + value.w};
    } else {
      node = value;
    }
  });
}

}  // namespace neve::cuda
