// The passes of an implicit step over the particles: gather the gradient of a velocity, make a matrix of it, scatter that.
//
// In units of cells as the transfer has them, G = sum_i u_i g_i^T with grad u = scale G, and a matrix A of a particle gives
// A g_i to node i. A home reads its tile and writes into another; tiles of one colour share no node, so the sums of a node are
// made in the order of p2g.
#pragma once

#include "cpu/grid/gather.hpp"
#include "cpu/implicit/nodes/nodes.hpp"
#include "cpu/p2g.hpp"

namespace neve {

namespace detail {

// The gradient that a pack of particles sees.
template <class T, class Spline, class Weights>
class GradientOf {
  using R = Lanes<T>;
  using Stored = StoredWeights<Weights, 4>;

 public:
  Stencils<T, Spline, Stored::count> stencils;

  void fill(const TileFrame<T>& frame, const Vec3<R>& way) { stencils.template fill<Stored>(frame, way); }
  const Vec3<R>* shift() const { return Stored::count == 1 ? &stencils.shift : nullptr; }
  Mat3<R> operator()(const Gather<T, Spline>& from, int count) {
    from.affine(stencils, count, sums_);
    Mat3<R> G{vector(1), vector(2), vector(3)};
    if constexpr (Stored::count == 1) {
      const Vec3<R> u = vector(0);
      for (int a = 0; a < 3; ++a) G.column(a) = G.column(a) + u * stencils.shift[a];
    }
    return G;
  }
  // The mean of the velocity that was gathered last.
  Vec3<R> mean() const { return vector(0); }

 private:
  Vec3<R> vector(int n) const {
    Vec3<R> a;
    R unused;
    load_quads(sums_[n], a.x, a.y, a.z, unused);
    return a;
  }
  alignas(64) T sums_[4][4 * width<R>];
};

// f(first particle, how many, their way from the tile's first node) for each pack of a home.
template <class T, class F>
void each_pack(const State<T>& state, const TileFrame<T>& frame, const Home& home, F&& f) {
  using R = Lanes<T>;
  for (std::uint32_t done = 0; done < home.count; done += width<R>) {
    const std::size_t p = home.begin + done;
    const int count = std::min<int>(width<R>, static_cast<int>(home.count - done));
    f(p, count, load_way<R>(state, frame, p, count));
  }
}

}  // namespace detail

// f(first particle, how many, sum_i w_ip u_i, G) for each pack of all homes, in parallel. f's results are merged (see
// merge_each).
template <class Out, class T, class Spline, class Weights, class F>
Out each_gathered(const Model<T>& model, const State<T>& state, Grid<T>& grid, NodeField<T>& u, F&& f) {
  return merge_each<Out>(grid.moving, [&](std::size_t h) {
    const Home& home = grid.homes[h];
    Tile<T> tile;
    tile.load_from(home, [&](std::int32_t b) { return u.block(std::size_t(b)); });
    const Gather<T, Spline> from(tile);
    const auto frame = TileFrame<T>::template of<Spline>(model.dx, home.at);
    detail::GradientOf<T, Spline, Weights> gradient;
    Out out;
    detail::each_pack(state, frame, home, [&](std::size_t p, int count, const Vec3<Lanes<T>>& way) {
      gradient.fill(frame, way);
      const Mat3<Lanes<T>> G = gradient(from, count);
      out.merge(f(p, count, gradient.mean(), G));
    });
    return out;
  });
}
// The same of f(first particle, how many, G).
template <class Out, class T, class Spline, class Weights, class F>
Out each_gradient(const Model<T>& model, const State<T>& state, Grid<T>& grid, NodeField<T>& u, F&& f) {
  return each_gathered<Out, T, Spline, Weights>(
      model, state, grid, u, [&](std::size_t p, int count, const Vec3<Lanes<T>>&, const Mat3<Lanes<T>>& G) {
        return f(p, count, G);
      });
}

// to_i += sum_p f(first particle, how many, G of u) g_i. Without `u`, G is zero.
template <class T, class Spline, class Weights, class F>
void add_through_particles(const Model<T>& model, const State<T>& state, Grid<T>& grid, NodeField<T>* u,
                           NodeField<T>& to, F&& f) {
  using R = Lanes<T>;
  grid.turns.each(grid.homes, [&](const Home& home, const Home&) {
    Tile<T> tile, sums;
    if (u) tile.load_from(home, [&](std::int32_t b) { return u->block(std::size_t(b)); });
    sums.clear();
    const Gather<T, Spline> from(tile);
    Scatter<T, Spline> scatter(sums);
    const auto frame = TileFrame<T>::template of<Spline>(model.dx, home.at);
    detail::GradientOf<T, Spline, Weights> gradient;
    detail::Carried<T, 4> carried;
    detail::each_pack(state, frame, home, [&](std::size_t p, int count, const Vec3<R>& way) {
      gradient.fill(frame, way);
      const Mat3<R> G = u ? gradient(from, count) : Mat3<R>{};
      carried.set_affine(Vec3<R>{}, R{}, f(p, count, G), gradient.shift());
      detail::scatter_affine(gradient.stencils, carried, count, scatter);
    });
    scatter.flush();
    sums.add_to(home, [&](std::int32_t b) { return to.block(std::size_t(b)); });
  });
}

}  // namespace neve
