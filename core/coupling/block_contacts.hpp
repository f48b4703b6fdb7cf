// Contacts of grid nodes with solids, kept until it is known how the bodies move.
#pragma once

#include <cstdint>
#include <vector>

#include "coupling/body_response.hpp"
#include "math/real.hpp"

namespace neve {

// Contacts of one block's nodes with solids.
template <class T>
struct BlockContacts {
  using R = Lanes<T>;
  using Mask = decltype(R{} < R{});
  struct Contact {
    const Solid<T>* solid;
    Mask inside;
    Facing<R> facing;
    Vec3<R> arm;  // from the solid's centre [m]
  };
  struct NodePack {
    Vec3<R> v;
    Lift<R> lift;
    R m;
    int first;               // node in the block
    std::size_t begin, end;  // of its contacts
  };
  std::int32_t block = 0;
  std::vector<NodePack> nodes;
  std::vector<Contact> contacts;

  void clear(std::int32_t b) { block = b, nodes.clear(), contacts.clear(); }
  // Add the contacts of the nodes from the block's `first` with the `near` solids, copies of those in `all`.
  template <class Solids>
  void add(const Solids& near, const std::vector<Solid<T>>& all, const Vec3<R>& x, const Vec3<R>& v,
           const Lift<R>& lift, R m, int first, T skin) {
    const std::size_t begin = contacts.size();
    each_holding(near, x, m, skin, [&](const Solid<T>& solid, const Vec3<R>& normal, const Mask& inside) {
      const Facing<R> there = facing_before(solid, x, normal, v, splat<R>(lift.dt), inside);
      contacts.push_back({&all[std::size_t(solid.index)], inside, there, x - spread<R>(solid.centre)});
    });
    if (contacts.size() > begin) nodes.push_back({v, lift, m, first, begin, contacts.size()});
  }
};

}  // namespace neve
