// Grains: what a particle of snow is drawn as. The grains of a particle depend on its id alone, so they go with it from
// frame to frame.
#pragma once

#include <span>
#include <vector>

#include "render/view/vec.hpp"

namespace neve::surface {

using namespace render;  // vectors and random numbers

// Random numbers of one particle, by its id.
class Dice {
 public:
  explicit Dice(std::uint64_t id)
      : seed_(render::scramble(std::uint32_t(id) ^ render::scramble(std::uint32_t(id >> 32) + 0x9e3779b9u))) {
  }
  float operator()(std::uint32_t n) const { return render::unit(render::scramble(seed_ + n * 0x85ebca6bu)); }

 private:
  std::uint32_t seed_;
};

inline float fraction(float a) { return a - std::floor(a); }

// Point number n of a sequence that fills the unit cube evenly (Roberts 2018: powers of the root of x^4 = x + 1),
// shifted at random by `dice`; from -1/2 to 1/2.
inline Vec3f spread(const Dice& dice, int n) {
  constexpr float step[3] = {0.8191725134f, 0.6710436067f, 0.5497004779f};
  const auto axis = [&](int a) { return fraction(dice(std::uint32_t(a)) + float(n) * step[a]) - 0.5f; };
  return {axis(0), axis(1), axis(2)};
}

// Point in the unit ball from three random numbers.
inline Vec3f in_ball(float a, float b, float c) {
  const float z = 2 * a - 1, flat = std::sqrt(std::max(1 - z * z, 0.0f)), turn = 6.2831853f * b;
  return Vec3f{flat * std::cos(turn), flat * std::sin(turn), z} * std::cbrt(c);
}

constexpr int most_crumbs = 8;

// Which crumb a grain of a lone particle belongs to: the first has half of them, the next a quarter, and so on.
inline int crumb_of(int grain, int count) {
  int crumb = 0, left = count, first = 0;
  while (crumb + 1 < most_crumbs) {
    const int size = (left + 1) / 2;
    if (grain < first + size) break;
    first += size, left -= size, ++crumb;
  }
  return crumb;
}

// Return the grains of particles, `count` for each, one particle after the other.
// Among others a particle fills its cell of side 1.15 spacing. A lone one is no ball: its grains gather in up to eight
// crumbs, each half of the one before, which lie about as far apart as the spacing.
// x: positions [m]; id: of each; lone: 0 among others, 1 alone; offset(p): matrix that carries the places of the grains
// beside particle p; spacing: of particles at rest [m]. Writes to `out`, one for each grain.
template <class F>
void grains(std::span<const Vec3f> x, std::span<const std::int64_t> id, std::span<const float> lone,
            F&& offset, float spacing, int count, Vec3f* out) {
  const float size = spacing / std::cbrt(float(count));
  std::vector<int> crumb(static_cast<std::size_t>(count));
  std::vector<float> members(most_crumbs, 0.0f);
  for (int g = 0; g < count; ++g) {
    crumb[std::size_t(g)] = crumb_of(g, count);
    members[std::size_t(crumb[std::size_t(g)])] += 1;
  }
#pragma omp parallel for schedule(static)
  for (std::int64_t p = 0; p < std::int64_t(x.size()); ++p) {
    const Dice dice{std::uint64_t(id[std::size_t(p)])};
    const float alone = lone[std::size_t(p)];
    const Mat3f carry = offset(std::size_t(p));
    for (int g = 0; g < count; ++g) {
      Vec3f place = spread(dice, g) * (1.15f * spacing);
      if (alone > 0) {
        const std::uint32_t c = std::uint32_t(crumb[std::size_t(g)]), n = 16 + 4 * std::uint32_t(g);
        const Vec3f centre = in_ball(dice(1000 + 3 * c), dice(1001 + 3 * c), dice(1002 + 3 * c)) * spacing;
        const Vec3f within =
            in_ball(dice(2000 + n), dice(2001 + n), dice(2002 + n)) * (0.62f * std::cbrt(members[c]));
        place = mix(place, centre + within * size, alone);
      }
      out[std::size_t(p) * std::size_t(count) + std::size_t(g)] = x[std::size_t(p)] + carry * place;
    }
  }
}

}  // namespace neve::surface
