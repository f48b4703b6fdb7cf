// A packing for particles to begin with.
#pragma once

#include "particles/listing.hpp"

namespace neve {

// Move particles that overlap apart, each by half of its overlaps over the root of their number.
template <class T>
void relax(ParticleState<T>& s, const Neighbours<T>& lists) {
  Field<T, 3> moved;
  moved.resize(s.count);
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      T push[3] = {0, 0, 0};
      int pairs = 0;
      lists.each(p, [&](std::uint32_t e) {
        const auto q = std::size_t(lists.row[e]);
        T d[3], d2 = 0;
        for (int k = 0; k < 3; ++k) d[k] = s.x.column(k)[p] - s.x.column(k)[q], d2 += d[k] * d[k];
        const T radii = s.radius.column(0)[p] + s.radius.column(0)[q], far = std::sqrt(d2);
        if (far >= radii || far == T(0)) return;
        for (int k = 0; k < 3; ++k) push[k] += d[k] / far * (radii - far) * T(0.5);
        ++pairs;
      });
      for (int k = 0; k < 3; ++k) moved.column(k)[p] = pairs ? push[k] / std::sqrt(T(pairs)) : T(0);
    }
  });
  each_chunk(s.count, [&](int, std::size_t begin, std::size_t end) {
    for (int k = 0; k < 3; ++k) {
      for (std::size_t p = begin; p < end; ++p) s.x.column(k)[p] += moved.column(k)[p];
    }
  });
}

}  // namespace neve
