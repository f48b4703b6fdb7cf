// Which points the sun reaches past the others: a map of them as the sun sees them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "threads.hpp"

namespace neve {

// Return for each of `count` points whether it lies within `depth` [m] behind the first one in the same square, `side` [m]
// wide, of a plane that faces the sun. place(n) is where point n is [m]. Solids cast no shadow.
template <class Place>
std::vector<char> sunlit(std::size_t count, const Place& place, double side, double depth,
                         const std::array<double, 3>& towards) {
  const std::size_t k = std::abs(towards[0]) < 0.6 ? 0 : 1;
  std::array<double, 3> a{}, b{};
  for (std::size_t i = 0; i < 3; ++i) a[i] = (i == k) - towards[k] * towards[i];
  const double norm = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  for (double& component : a) component /= norm;
  for (std::size_t i = 0; i < 3; ++i)
    b[i] = towards[(i + 1) % 3] * a[(i + 2) % 3] - towards[(i + 2) % 3] * a[(i + 1) % 3];
  std::vector<std::uint64_t> square(count);
  std::vector<double> height(count);
  each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const std::array<double, 3> x = place(n);
      double u = 0, v = 0, w = 0;
      for (std::size_t i = 0; i < 3; ++i) u += a[i] * x[i], v += b[i] * x[i], w += towards[i] * x[i];
      const auto cell = [&](double at) {
        return std::uint64_t(std::uint32_t(std::int32_t(std::floor(at / side))));
      };
      square[n] = cell(u) << 32 | cell(v), height[n] = w;
    }
  });
  std::unordered_map<std::uint64_t, double> first;
  first.reserve(count / 4);
  for (std::size_t n = 0; n < count; ++n) {
    const auto [at, fresh] = first.emplace(square[n], height[n]);
    if (!fresh) at->second = std::max(at->second, height[n]);
  }
  std::vector<char> lit(count);
  each_chunk(count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) lit[n] = height[n] >= first.find(square[n])->second - depth;
  });
  return lit;
}

}  // namespace neve
