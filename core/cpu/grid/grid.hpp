// The sparse grid: blocks of 4x4x4 nodes, allocated where particles are.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "coupling/block_contacts.hpp"
#include "coupling/exchange.hpp"
#include "cpu/grid/halo.hpp"
#include "cpu/grid/turns.hpp"
#include "mpm/state.hpp"

namespace neve {

inline constexpr int block_values = 64 * 4;

// What grid_update sees of a block's velocities.
template <class T>
struct BlockBounds {
  Vec3<T> low, high;  // over the nodes that are not too light; low > high if there are none
  T change;           // largest change of velocity, along one axis
  bool finite;
};

template <class T>
struct Grid {
  std::vector<Home>
      homes;               // by rising key, so neighbours in memory are neighbours in space; after those that
                           // move, those that sleep beside them and only give
  std::size_t moving = 0;  // homes that move
  Turns turns;             // in which homes give
  std::vector<BlockCoord> blocks;  // node blocks, by rising key
  Column<T> momentum;              // 4 per node: (m v, m) after p2g, (v, m) after grid_update
  Column<T> change;                // 4 per node, flip only: (f, -) after p2g, (v - v_n, -) after grid_update
  Column<T>
      lift;  // 4 per node, of solids with play, or with heat: (m s, m f) after p2g, (change of s, -) then
  std::size_t count = 0;  // particles sorted
  std::size_t awake = 0;  // of them, the first ones: those in homes that move
  T lightest = T(0);      // mass of the lightest particle [kg]
  bool current = false;   // the homes still hold all their particles
  bool has_change = false, has_lift = false, has_water = false;
  std::vector<BlockBounds<T>> bounds;  // of each block, by grid_update
  std::vector<ExchangeSum> node_exchange,
      particle_exchange;                   // of each block and each home: one step's exchange with solids
  std::vector<Exchange> exchanged;         // with each solid, over the steps since it was last taken
  std::vector<BlockContacts<T>> contacts;  // of blocks whose nodes may meet a solid that the snow moves

  T* node(std::int32_t block) { return momentum.data() + std::size_t(block) * block_values; }
  T* node_lift(std::int32_t block) { return lift.data() + std::size_t(block) * block_values; }
  T* node_change(std::int32_t block) { return change.data() + std::size_t(block) * block_values; }
  // The arrays of values of a block: momentum, and those of change and lift that there are.
  int layers() const { return 1 + has_change + (has_lift || has_water); }
  T* layer(int k, std::int32_t block) {
    return k == 0 ? node(block) : k == 1 && has_change ? node_change(block) : node_lift(block);
  }
  std::size_t bytes() const {
    return (momentum.size() + change.size() + lift.size() + halo.kept.size() + halo.sent.size() +
            halo.received.size()) *
               sizeof(T) +
           homes.size() * sizeof(Home) + blocks.size() * sizeof(BlockCoord) +
           order.size() * sizeof(std::uint32_t) + spare.size() + home_of.size() * sizeof(std::int32_t);
  }

  // Snow at rest, see cpu/sleep.hpp.
  std::vector<Home> sleepers;  // homes that are not stepped, by rising key
  BlockMap sleeper_at;         // their places in that list
  bool whole = true;           // the next sort looks at all homes
  std::vector<T> drift;        // the largest mean velocity of late in each home that moves [m/s]
  bool may_sleep = true;
  double rest_wave = 0;  // wave speed in the stiffest snow since all of it was looked at [m/s]
  double rest_room = std::numeric_limits<double>::infinity();  // and the smallest J over that of ice [1]

  // A run on several ranks, see cpu/ranks.
  Halo<T> halo;
  EarlierOrder earlier;

  // scratch of sort()
  std::vector<std::uint32_t> order;
  std::vector<std::int32_t> home_of;
  Column<char> spare;
};

}  // namespace neve
