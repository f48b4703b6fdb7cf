// The hot loops of the step, each as a function of its own, so that test_codegen.py can look at their instructions.
#include <tuple>

#include "cpu/block_update.hpp"
#include "cpu/g2p.hpp"
#include "cpu/p2g.hpp"
#include "transfer/weights.hpp"

namespace neve::probe {

using S = Quadratic;

template <class T>
using Batch = AffineBatch<T, S, 64>;

template <class T>
void scatter(const Batch<T>& batch, int count, Tile<T>& tile) {
  neve::scatter(batch, count, tile);
}

template <class T>
void gather(const Stencils<T, S, 1>& stencils, const Tile<T>& tile, T (*out)[4 * lane_count<T>]) {
  const Gather<T, S> from(tile);
  from.affine(stencils, lane_count<T>, out);
}

template <class T>
void fill(Stencils<T, S, 1>& stencils, const TileFrame<T>& frame, const Vec3<Lanes<T>>& x) {
  stencils.template fill<SplineWeights>(frame, x);
}

template <class T>
void return_map(const T* F, const Snow& snow, std::size_t packs, T* out) {
  using R = Lanes<T>;
  const auto q = Stomakhin2013::parameters(snow, splat<R>(1), splat<R>(1));
  for (std::size_t i = 0; i < packs; ++i, F += 9 * width<R>, out += 17 * width<R>) {
    Mat3<R> F_trial;
    for (int k = 0; k < 9; ++k) F_trial(k % 3, k / 3) = load<R>(F + k * width<R>);
    const auto mapped = Stomakhin2013::return_map(F_trial, splat<R>(1), q);
    for (int k = 0; k < 9; ++k) store(out + k * width<R>, mapped.F_E(k % 3, k / 3));
    const Sym3<R>& tau = mapped.stress.tau;
    const R rest[8] = {mapped.J_P, tau.xx, tau.yy, tau.zz, tau.xy, tau.xz, tau.yz, mapped.stress.modulus};
    for (int k = 0; k < 8; ++k) store(out + (9 + k) * width<R>, rest[k]);
  }
}

template <class T>
void node_rows(const detail::BlockUpdate<T>& update, T* node) {
  for (int r = 0; r < 16; ++r) update.row(node + 16 * r, node + 16 * r);
}

template <class T>
constexpr auto all = std::make_tuple(scatter<T>, gather<T>, fill<T>, return_map<T>, node_rows<T>);
[[gnu::used]] constexpr auto float32 = all<float>;
[[gnu::used]] constexpr auto float64 = all<double>;

}  // namespace neve::probe
