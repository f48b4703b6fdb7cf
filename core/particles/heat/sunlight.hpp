// Which particles the sun reaches past the others: a map of the particles as the sun sees them.
#pragma once

#include <unordered_map>
#include <vector>

#include "particles/enthalpy.hpp"
#include "particles/state.hpp"

namespace neve {

// Return for each particle whether it lies within 2.5 radii behind the first one in the same square, two radii wide, of a
// plane that faces the sun. Solids cast no shadow.
template <class T>
std::vector<char> sunlit(const ParticleState<T>& s, const std::array<double, 3>& towards) {
  double radius = 0;
  for (std::size_t p = 0; p < s.count; ++p) radius = std::max(radius, double(s.radius.column(0)[p]));
  const std::size_t k = std::abs(towards[0]) < 0.6 ? 0 : 1;
  std::array<double, 3> a{}, b{};
  for (std::size_t i = 0; i < 3; ++i) a[i] = (i == k) - towards[k] * towards[i];
  const double norm = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  for (double& component : a) component /= norm;
  for (std::size_t i = 0; i < 3; ++i)
    b[i] = towards[(i + 1) % 3] * a[(i + 2) % 3] - towards[(i + 2) % 3] * a[(i + 1) % 3];
  std::vector<std::uint64_t> square(s.count);
  std::vector<double> depth(s.count);
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      double u = 0, v = 0, w = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double x = s.x.column(int(i))[p];
        u += a[i] * x, v += b[i] * x, w += towards[i] * x;
      }
      const auto cell = [&](double at) {
        return std::uint64_t(std::uint32_t(std::int32_t(std::floor(at / (2 * radius)))));
      };
      square[p] = cell(u) << 32 | cell(v), depth[p] = w;
    }
  });
  std::unordered_map<std::uint64_t, double> first;
  first.reserve(s.count / 4);
  for (std::size_t p = 0; p < s.count; ++p) {
    const auto [at, fresh] = first.emplace(square[p], depth[p]);
    if (!fresh) at->second = std::max(at->second, depth[p]);
  }
  std::vector<char> lit(s.count);
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p)
      lit[p] = depth[p] >= first.find(square[p])->second - 2.5 * radius;
  });
  return lit;
}

}  // namespace neve
