// Snow at rest that is not stepped.
//
// A home sleeps when all of its particles have been slow for long enough and no solid moves near it. Its particles stay where
// they are, with the stress that they have. Sleepers beside a home that moves still give it their mass and their force,
// so that it rests on them; nobody gives anything to the nodes that only sleepers see.
#pragma once

#include "cpu/grid/sort.hpp"
#include "cpu/near.hpp"
#include "mpm/dispatch.hpp"

namespace neve {

namespace detail {

// How far from the middle of a home's tile its nodes and particles lie [cells], and how much nearer a moving solid must come
// to wake it than to keep it awake.
inline constexpr double home_middle = 3.5, home_reach = 7.1, solid_play = 1.0;

template <class T>
bool moves(const Solid<T>& solid) {
  const Vec3<T> zero{};
  const auto any = [&](const Vec3<T>& a) { return dot(a, a) > dot(zero, zero); };
  return solid.body >= 0 || any(solid.velocity) || any(solid.omega) || any(solid.belt);
}

// Whether a solid that moves may touch the home within `play` [cells].
template <class T>
bool solid_moves_near(const Model<T>& model, BlockCoord at, double play) {
  const T reach = T((home_reach + play) * model.dx);
  const Vec3<T> middle = middle_of(model, at, home_middle);
  for (const Solid<T>& solid : model.solids) {
    if (moves(solid) && is_near(solid, middle, reach)) return true;
  }
  return false;
}

// Give the particles of the homes `wakes` of grid.sleepers a new start, by the next sort.
template <class T>
void rouse(State<T>& state, Grid<T>& grid, const std::vector<std::size_t>& wakes) {
  if (wakes.empty()) return;
  grid.current = false, grid.whole = true;
  for (std::size_t k : wakes) {
    const Home& home = grid.sleepers[k];
    for (int n = 0; n < state.rest.components(); ++n)
      std::fill_n(state.rest.column(n) + home.begin, home.count, T(0));
  }
}

// Whether a particle may sleep: it has rested for long enough; if it slept, nobody has written a velocity since.
template <class T>
bool is_calm(const State<T>& state, std::size_t p, T after) {
  const T rest = state.rest.column(0)[p];
  if (rest < std::numeric_limits<T>::infinity()) return rest >= after;
  return state.v.column(0)[p] == T(0) && state.v.column(1)[p] == T(0) && state.v.column(2)[p] == T(0);
}

// Part the homes, and with them grid.order, into those that move, first, and those that sleep.
template <class T>
void part_homes(const Model<T>& model, const State<T>& state, Grid<T>& grid) {
  const auto after = static_cast<T>(model.sleep_after);
  std::vector<char> sleeps(grid.homes.size());
  each_index(grid.homes.size(), [&](std::size_t h) {
    const Home& home = grid.homes[h];
    bool rests = true;
    for (std::uint32_t k = 0; k < home.count && rests; ++k)
      rests = is_calm(state, grid.order[home.begin + k], after);
    sleeps[h] = grid.may_sleep && rests && !solid_moves_near(model, home.at, 2 * solid_play);
  });
  std::vector<Home> moving;
  grid.sleepers.clear();
  std::vector<std::uint32_t> order;
  order.reserve(grid.order.size());
  for (const bool asleep : {false, true}) {
    for (std::size_t h = 0; h < grid.homes.size(); ++h) {
      if (bool(sleeps[h]) != asleep) continue;
      Home home = grid.homes[h];
      const auto first = grid.order.begin() + home.begin;
      home.begin = static_cast<std::uint32_t>(order.size());
      order.insert(order.end(), first, first + home.count);
      (asleep ? grid.sleepers : moving).push_back(home);
    }
    if (!asleep) grid.awake = order.size();
  }
  grid.homes = std::move(moving);
  grid.order = std::move(order);
  grid.sleeper_at = BlockMap(grid.sleepers.size() * 2 + 8);
  for (const Home& home : grid.sleepers) grid.sleeper_at.insert(key_of(home.at));
}

// Bring the particles of sleepers to a stand: those that have just come to rest still have a little velocity. Those that
// slept and are in a home that moves, with snow that came to them, begin to rest anew.
template <class T>
void bring_to_a_stand(const Model<T>& model, State<T>& state, const Grid<T>& grid) {
  constexpr T asleep = std::numeric_limits<T>::infinity();
  T* rest = state.rest.column(0);
  const int velocities = 3 * more_modes(model);
  each_index(grid.homes.size(), [&](std::size_t h) {
    const Home& home = grid.homes[h];
    std::replace(rest + home.begin, rest + home.begin + home.count, asleep, T(0));
  });
  each_index(grid.sleepers.size(), [&](std::size_t k) {
    const Home& home = grid.sleepers[k];
    for (std::size_t p = home.begin; p < home.begin + std::size_t(home.count); ++p) {
      if (rest[p] == asleep) continue;
      rest[p] = asleep;
      for (int a = 0; a < 3; ++a) state.rest.column(1 + a)[p] = state.v.column(a)[p] = T(0);
      for (int a = 0; a < 9; ++a) state.C.column(a)[p] = T(0);
      for (int a = 0; a < velocities; ++a) state.modes.column(a)[p] = T(0);
    }
  });
}

// The sleepers whose block a moving home has come to.
template <class T>
std::vector<std::size_t> met_sleepers(Grid<T>& grid, const std::vector<BlockKey>& keys) {
  std::vector<std::size_t> met;
  for (BlockKey key : keys) {
    const std::int32_t k = grid.sleeper_at.find(key);
    if (k != BlockMap::none) met.push_back(static_cast<std::size_t>(k));
  }
  return met;
}

// Call f(place in grid.sleepers) for each sleeper that shares a node with the home.
template <class T, class F>
void each_sleeper_beside(Grid<T>& grid, const Home& home, F&& f) {
  for (int n = 0; n < 27; ++n) {
    const std::int32_t k = grid.sleeper_at.find(
        key_of({home.at.x + n / 9 - 1, home.at.y + n / 3 % 3 - 1, home.at.z + n % 3 - 1}));
    if (k != BlockMap::none) f(static_cast<std::size_t>(k));
  }
}

// Add the sleepers beside homes that move to grid.homes, after those.
template <class T>
void add_border(Grid<T>& grid) {
  std::vector<std::size_t> border;
  for (std::size_t h = 0; h < grid.moving; ++h)
    each_sleeper_beside(grid, grid.homes[h], [&](std::size_t k) { border.push_back(k); });
  std::sort(border.begin(), border.end());
  border.erase(std::unique(border.begin(), border.end()), border.end());
  for (std::size_t k : border) grid.homes.push_back(grid.sleepers[k]);
}

}  // namespace detail

// Sort the state's particles and lay out the grid for them; of the sleepers only those that something has woken, unless
// grid.whole asks for all. Throws std::domain_error on a lost particle.
template <class T>
void sort(const Model<T>& model, State<T>& state, Grid<T>& grid) {
  grid.current = false;
  const detail::Placing<T> placing = detail::placing_of(model);
  std::vector<BlockKey> keys;
  if (grid.sleepers.empty()) grid.whole = true;
  if (!grid.whole) {
    keys = detail::find_homes(state, grid.awake, placing, grid);
    detail::rouse(state, grid, detail::met_sleepers(grid, keys));
  }
  if (grid.whole) {
    grid.awake = state.count;
    keys = detail::find_homes(state, state.count, placing, grid);
  }
  detail::order_by_home<T>(grid.awake, keys, grid);
  detail::order_by_cell(state, placing, grid);
  if (grid.whole && model.sleeps()) detail::part_homes(model, state, grid);
  detail::permute(state, grid);
  if (grid.whole && model.sleeps()) detail::bring_to_a_stand(model, state, grid);
  grid.moving = grid.homes.size();
  detail::add_border(grid);
  detail::lay_out_blocks(grid);
  detail::make_room(model, state, grid);
  grid.earlier = {};
  grid.whole = false;
  grid.current = true;
}

// Wake the sleepers that the step has stirred: those beside snow that gets away from its place, and those that a moving solid
// comes to.
template <class T>
void stir(const Model<T>& model, State<T>& state, Grid<T>& grid) {
  if (grid.sleepers.empty()) return;
  std::vector<std::size_t> wakes;
  for (std::size_t h = 0; h < grid.moving; ++h) {
    if (!(grid.drift[h] <= T(2 * model.sleep_speed)))
      detail::each_sleeper_beside(grid, grid.homes[h], [&](std::size_t k) { wakes.push_back(k); });
  }
  const auto moves = [](const Solid<T>& solid) { return detail::moves(solid); };
  if (std::any_of(model.solids.begin(), model.solids.end(), moves)) {
    std::vector<char> near(grid.sleepers.size());
    each_index(near.size(), [&](std::size_t k) {
      near[k] = detail::solid_moves_near(model, grid.sleepers[k].at, detail::solid_play);
    });
    for (std::size_t k = 0; k < near.size(); ++k) {
      if (near[k]) wakes.push_back(k);
    }
  }
  detail::rouse(state, grid, wakes);
}

}  // namespace neve
