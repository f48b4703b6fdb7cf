// How the snow around a particle has turned and stretched since the first frame: its grains go with it.
#pragma once

#include <span>
#include <vector>

#include "math/svd3.hpp"
#include "render/view/vec.hpp"

namespace neve::surface {

using namespace render;  // vectors

// Stretches of grains' places: beyond, snow is torn or crushed, and grains would be needles or plates.
constexpr float least_stretch = 0.65f, most_stretch = 1.5f;

// Distance between neighbours over the first one, from which they begin to count less, and at which they are none.
constexpr float near_ratio = 1.75f, gone_ratio = 3.0f;

// Columns of a, each times a number of d: a d^T.
inline Mat3f outer(Vec3f a, Vec3f d) { return {a * d.x, a * d.y, a * d.z}; }

// Inverse of a symmetric matrix of positive eigenvalues.
inline Mat3f symmetric_inverse(const Mat3f& m) {
  const Mat3f adjugate{cross(m.c1, m.c2), cross(m.c2, m.c0), cross(m.c0, m.c1)};
  return scaled(adjugate, 1.0f / dot(m.c0, adjugate.c0));
}

// Return for each particle the F that best moves its neighbours of the first frame to where they are:
// the least of sum_j w_j |x_j - x_p - F (X_j - X_p)|^2, so F = B M^-1 with B = sum w d D^T and M = sum w D D^T.
// w_j falls from 1 to 0 as a neighbour parts. The identity is added to B and M, a thousandth of what M is with all
// neighbours, and more where most of them are lost: a particle that has lost all has F = 1.
// X, x: places in the first frame and now [m], not finite where the particle is gone; near: `count` neighbours of each.
inline std::vector<Mat3f> gradients(std::span<const Vec3f> X, std::span<const Vec3f> x,
                                    std::span<const std::int32_t> near, std::size_t count) {
  std::vector<Mat3f> out(x.size(), identity<float>());
#pragma omp parallel for schedule(static)
  for (std::int64_t p = 0; p < std::int64_t(x.size()); ++p) {
    const auto own = std::size_t(p);
    Mat3f B{}, M{};
    float kept = 0, full = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const auto j = std::size_t(near[own * count + k]);
      const Vec3f D = X[j] - X[own], d = x[j] - x[own];
      const float D2 = dot(D, D), ratio = std::sqrt(dot(d, d) / std::max(D2, 1e-30f));
      full += D2;
      if (!(ratio < gone_ratio)) continue;  // also where one of them is gone
      const float w = 1.0f - smoothstep(near_ratio, gone_ratio, ratio);
      B = B + scaled(outer(d, D), w);
      M = M + scaled(outer(D, D), w);
      kept += w;
    }
    if (!(kept > 0 && full > 0)) continue;
    const float lost = 1.0f - kept / float(count), most = lost * lost * lost;
    const Mat3f rest = scaled(identity<float>(), (1e-3f + 0.3f * most * most) * full);
    out[own] = (B + rest) * symmetric_inverse(M + rest);
  }
  return out;
}

struct Carried {
  Mat3f turn;  // rotation R of F = R S
  Mat3f
      offset;  // R S with the stretches kept within bounds: it moves the place of a grain beside its particle
};

inline Carried carried(const Mat3f& F) {
  const Svd3<float> s = svd3(F);
  const auto held = [](float sigma) { return std::clamp(sigma, least_stretch, most_stretch); };
  const Mat3f Vt{
      {s.V.c0.x, s.V.c1.x, s.V.c2.x}, {s.V.c0.y, s.V.c1.y, s.V.c2.y}, {s.V.c0.z, s.V.c1.z, s.V.c2.z}};
  const Mat3f stretched{s.U.c0 * held(s.sigma.x), s.U.c1 * held(s.sigma.y), s.U.c2 * held(s.sigma.z)};
  return {s.U * Vt, stretched * Vt};
}

}  // namespace neve::surface
