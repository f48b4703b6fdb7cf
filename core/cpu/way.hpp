// Where particles are in their home's tile: exact to the rounding of the way from there, however far the tile is.
#pragma once

#include "cpu/fields.hpp"
#include "cpu/grid/tile.hpp"

namespace neve {

// The way of particles from the first node of their home's tile [m].
template <class R, class T>
NEVE_INLINE Vec3<R> load_way(const State<T>& state, const TileFrame<T>& frame, std::size_t p, int count) {
  const Vec3<R> way = load_vector<R>(state.x, p, count) - spread<R>(frame.corner);
  if (!state.is_fine()) return way - spread<R>(frame.beyond);
  return way + (load_vector<R>(state.beyond, p, count) - spread<R>(frame.beyond));
}
template <class R, class T>
NEVE_INLINE void store_way(State<T>& state, const TileFrame<T>& frame, std::size_t p, const Vec3<R>& way,
                           int count) {
  const Vec3<R> from = way + spread<R>(frame.beyond), x = spread<R>(frame.corner) + from;
  store_vector(state.x, p, x, count);
  if (state.is_fine()) store_vector(state.beyond, p, from - (x - spread<R>(frame.corner)), count);
}

}  // namespace neve
