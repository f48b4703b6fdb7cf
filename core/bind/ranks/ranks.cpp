// neve._core.f32.ranks and f64.ranks: what a run on several ranks asks of the core besides the step.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/vector.h>

#include "bind/arrays.hpp"
#include "cpu/ranks/bodies.hpp"
#include "cpu/ranks/migration.hpp"

namespace neve::bind {

namespace {

using Keys = In<BlockKey, nb::shape<-1>>;
using RowNumbers = In<std::uint32_t, nb::shape<-1>>;
using Bytes = In<std::uint8_t, nb::shape<-1>>;

inline std::vector<BlockKey> list_of(const Keys& keys) { return {keys.data(), keys.data() + keys.shape(0)}; }

template <class E>
auto whole_array(std::vector<E>&& values) {
  const std::size_t n = values.size();
  return array(std::move(values), {n});
}

// Rows of particles, checked before memory is touched.
template <class T>
void require_rows(const State<T>& state, const RowNumbers& rows, bool rise) {
  for (std::size_t k = 0; k < rows.shape(0); ++k) {
    if (rows(k) >= state.count || (rise && k > 0 && rows(k) <= rows(k - 1)))
      throw nb::value_error("rows must rise, each a row of a particle");
  }
}

// Particles as bytes.
template <class T>
void bind_rows(nb::module_& m) {
  m.def("row_bytes", &row_bytes<T>, "Bytes of one particle.");
  m.def(
      "pack",
      [](State<T>& state, const RowNumbers& rows) {
        require_rows(state, rows, false);
        std::vector<std::uint8_t> bytes(rows.shape(0) * row_bytes(state));
        pack_rows(state, rows.data(), rows.shape(0), reinterpret_cast<char*>(bytes.data()));
        return whole_array(std::move(bytes));
      },
      "The bytes of the particles at rows (n,), column after column.");
  m.def(
      "unpack",
      [](State<T>& state, const RowNumbers& rows, const Bytes& bytes) {
        require_rows(state, rows, false);
        if (bytes.shape(0) != rows.shape(0) * row_bytes(state))
          throw nb::value_error("other bytes than rows");
        unpack_rows(state, rows.data(), rows.shape(0), reinterpret_cast<const char*>(bytes.data()));
      },
      "Put what pack() gave into rows (n,).");
}

// Who goes where.
template <class T>
void bind_migration(nb::module_& m) {
  m.def(
      "homes_now",
      [](const Model<T>& model, const State<T>& state) { return whole_array(homes_now(model, state)); },
      "The key of the block that each particle is in, (n,).");
  m.def(
      "owners",
      [](const Keys& keys, const Keys& cuts) { return whole_array(owners_of(list_of(keys), list_of(cuts))); },
      "The rank that owns each block, (n,), given their keys (n,) and where the ranks begin on the curve.");
  m.def(
      "curve",
      [](const Keys& keys) {
        std::vector<BlockKey> at = list_of(keys);
        for (BlockKey& key : at) key = curve_of(key);
        return whole_array(std::move(at));
      },
      "Where blocks (n,) are on the curve, (n,).");
  m.def(
      "note_order", [](const State<T>& state, Grid<T>& grid) { note_order(state, grid); },
      "Note the homes and rows of the particles at the last sort, before some go.");
  m.def(
      "homes_then",
      [](const Grid<T>& grid, const RowNumbers& rows) {
        std::vector<BlockKey> home(rows.shape(0));
        for (std::size_t k = 0; k < home.size(); ++k) home[k] = home_then(grid, rows(k));
        return whole_array(std::move(home));
      },
      "The homes of rows (n,) at the last sort, (n,).");
  m.def(
      "depart",
      [](State<T>& state, Grid<T>& grid, const RowNumbers& rows) {
        require_rows(state, rows, true);
        if (grid.earlier.home.size() != state.count) throw nb::value_error("call note_order() first");
        depart(state, grid, rows.data(), rows.shape(0));
      },
      "Let the particles at rows (n,) go.");
  m.def(
      "arrive",
      [](State<T>& state, Grid<T>& grid, const Keys& home, const RowNumbers& row, const Bytes& bytes) {
        const std::size_t n = home.shape(0);
        if (row.shape(0) != n || bytes.shape(0) != n * row_bytes(state) ||
            grid.earlier.home.size() != state.count)
          throw nb::value_error("homes, rows and bytes of different particles");
        arrive(state, grid, home.data(), row.data(), n, reinterpret_cast<const char*>(bytes.data()));
      },
      "Let particles come that were in these homes (n,) and rows (n,). Views of the state are no longer "
      "valid.");
}

// What is exchanged in each step.
template <class T>
void bind_halo(nb::module_& m) {
  m.def(
      "homes",
      [](const Grid<T>& grid) {
        std::vector<BlockKey> keys;
        std::vector<std::uint32_t> counts;
        for (const Home& home : grid.homes) keys.push_back(key_of(home.at)), counts.push_back(home.count);
        return nb::make_tuple(whole_array(std::move(keys)), whole_array(std::move(counts)));
      },
      "Keys of the blocks that own particles, rising (n,), and how many each has, (n,).");
  m.def(
      "border",
      [](const Grid<T>& grid, const Keys& cuts, std::int32_t rank) {
        std::vector<std::int32_t> ranks;
        std::vector<BlockKey> keys;
        for (const auto& [r, key] : border_of(grid, list_of(cuts), rank))
          ranks.push_back(r), keys.push_back(key);
        return nb::make_tuple(whole_array(std::move(ranks)), whole_array(std::move(keys)));
      },
      "Homes beside a block of another rank: the ranks, rising (n,), and the keys, (n,).");
  m.def(
      "lay_halo",
      [](Grid<T>& grid, const std::vector<bool>& lower, const std::vector<Keys>& mine,
         const std::vector<Keys>& theirs) {
        if (!grid.current || mine.size() != lower.size() || theirs.size() != lower.size())
          throw nb::value_error("lists of different neighbours, or a grid that is not sorted");
        std::vector<Neighbour> neighbours;
        for (std::size_t k = 0; k < lower.size(); ++k)
          neighbours.push_back({lower[k], list_of(mine[k]), list_of(theirs[k])});
        return lay_halo(grid, neighbours);
      },
      "Lay out the halo: the numbers of blocks given to and taken from each neighbour.");
}

// What of it is for Python.
template <class T>
void bind_found(nb::module_& m) {
  m.def(
      "pieces",
      [](Grid<T>& grid) {
        return nb::make_tuple(reinterpret_cast<std::uintptr_t>(grid.halo.sent.data()),
                              reinterpret_cast<std::uintptr_t>(grid.halo.received.data()),
                              std::size_t(grid.layers()) * block_values * sizeof(T));
      },
      "Addresses of what is sent and received, and the bytes of one block.");
  m.def(
      "counted",
      [](const Grid<T>& grid) {
        return std::count(grid.halo.counted.begin(), grid.halo.counted.end(), char(1));
      },
      "Node blocks that no lower rank has.");
  m.def(
      "border_homes", [](const Grid<T>& grid) { return grid.halo.border.size(); },
      "Homes whose nodes other ranks have too.");
  m.def(
      "take_ledger",
      [](Grid<T>& grid) {
        std::vector<std::uint8_t> bytes(grid.halo.ledger.size() * sizeof(LedgerRow));
        if (!bytes.empty()) std::memcpy(bytes.data(), grid.halo.ledger.data(), bytes.size());
        grid.halo.ledger.clear(), grid.halo.step = 0;
        return whole_array(std::move(bytes));
      },
      "Exchanges with solids since the last call, rows of LedgerRow as bytes.");
  m.def(
      "set_lightest", [](Grid<T>& grid, double mass) { grid.lightest = T(mass); },
      "Take over the mass of the lightest particle of all ranks [kg].");
  m.def(
      "unsort", [](Grid<T>& grid) { grid.current = false; },
      "Let the next step sort: a particle of some rank has left its home.");
  m.def(
      "lightest", [](const Grid<T>& grid) { return double(grid.lightest); },
      "Mass of the lightest particle [kg].");
}

// Bodies.
template <class T>
void bind_bodies(nb::module_& m) {
  m.def(
      "update_nodes",
      [](Model<T>& model, Grid<T>& grid, double dt) {
        if (grid.has_change != keeps_change(model) || grid.halo.counted.size() != grid.blocks.size())
          throw nb::value_error("the grid is of another model, or has no halo");
        BlocksNearBodies<T> found = update_nodes(model, grid, dt);
        return nb::make_tuple(whole_array(std::move(found.keys)), whole_array(std::move(found.values)));
      },
      "grid_update up to contacts with bodies: keys (n,) and values of the node blocks near those that no "
      "lower "
      "rank has.");
  m.def(
      "meet_bodies",
      [](Model<T>& model, Grid<T>& grid, double dt, const Keys& keys, const In<T, nb::shape<-1>>& values) {
        const std::size_t n = keys.shape(0);
        if (values.shape(0) != n * (1 + std::size_t(grid.has_lift)) * block_values)
          throw nb::value_error("keys and values of different blocks");
        return meet_bodies(model, grid, dt,
                           {list_of(keys), {values.data(), values.data() + values.shape(0)}});
      },
      "The rest of grid_update, given what update_nodes() has found on all ranks, by rising key.");
}

template <class T>
void bind_ranks_of(nb::module_& m) {
  auto ranks = m.def_submodule("ranks", "What a run on several ranks asks of the core.");
  bind_rows<T>(ranks);
  bind_migration<T>(ranks);
  bind_halo<T>(ranks);
  bind_found<T>(ranks);
  bind_bodies<T>(ranks);
}

}  // namespace

void bind_ranks(nb::module_& f32, nb::module_& f64) {
  bind_ranks_of<float>(f32);
  bind_ranks_of<double>(f64);
}

}  // namespace neve::bind
