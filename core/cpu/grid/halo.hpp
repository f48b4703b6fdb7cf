// What the ranks of a run tell each other of the nodes that homes of several of them cover. Empty on one rank.
//
// A home adds to the node blocks of its tile as one of eight colours, and a node block gets at most one home's sums of each
// colour. So a rank that is given what homes of other ranks add, each by itself, and adds it at the turn of its colour, has the
// sums of a run on one rank to the last bit, however many ranks there are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "coupling/exchange.hpp"
#include "cpu/grid/blocks.hpp"
#include "math/real.hpp"
#include "mpm/state.hpp"

namespace neve {

// What the nodes of a block (part 0) or the particles of a home (part 1) exchanged with a solid in one step.
struct LedgerRow {
  BlockKey block;
  std::uint32_t step;
  std::int16_t part, solid;
  Exchange exchange;
};

template <class T>
struct Halo {
  std::vector<std::int32_t> border;   // homes whose nodes other ranks have too: their sums are kept apart
  std::vector<std::int32_t> kept_of;  // of each home: its place in that list, or BlockMap::none
  std::vector<std::int32_t>
      given;  // what is sent, route after route: 8 times such a place, plus the block of the tile
  std::vector<std::int32_t> taken;  // what is received, route after route: the node block that it is added to
  std::array<std::vector<std::int32_t>, 8>
      taken_of;                    // the same by the colour of the home: places in that list
  std::vector<char> counted;       // of each node block: no lower rank has it, so this one counts it
  Column<T> kept, sent, received;  // blocks of values, layer after layer
  std::vector<LedgerRow> ledger;   // exchanges with solids, which are to be added up in the order of one rank
  std::uint32_t step = 0;          // steps in it
  bool shares = false;             // there are other ranks

  bool keeps(std::int32_t home) const {
    return !kept_of.empty() && kept_of[std::size_t(home)] != BlockMap::none;
  }
};

// Enter what a block of nodes or the particles of a home exchanged with each solid.
template <class T>
void enter(Halo<T>& halo, BlockKey block, int part, const ExchangeSum& sum) {
  sum.each([&](int solid, const Exchange& exchange) {
    halo.ledger.push_back({block, halo.step, std::int16_t(part), std::int16_t(solid), exchange});
  });
}

// How a state's rows stood before particles came and went: the home that each was in at the last sort, and its row there. A
// stable sort of one rank starts from this order.
struct EarlierOrder {
  std::vector<BlockKey> home;  // empty: nobody came or went
  std::vector<std::uint32_t> row;
  std::size_t stayed = 0;  // rows before those that came

  bool is_disturbed(std::size_t p) const { return p >= stayed || row[p] != p; }
};

}  // namespace neve
