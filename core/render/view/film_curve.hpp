// From light to bytes.
#pragma once

#include <vector>

#include "render/view/vec.hpp"

namespace neve::render {

// Bend light like film and code it as sRGB: a soft foot, a straight middle, a long shoulder, so that
// bright snow keeps its texture. A table, because a power per channel and pixel would take longer than the
// snow.
class FilmCurve {
 public:
  FilmCurve() : table_(entries + 1) {
    for (int e = 0; e <= entries; ++e) {
      const float root = most * float(e) / entries, light = root * root;
      const float exposed = 1.0f - std::exp(-1.05f * std::pow(light, 1.15f));
      const float coded =
          exposed <= 0.0031308f ? 12.92f * exposed : 1.055f * std::pow(exposed, 1.0f / 2.4f) - 0.055f;
      table_[std::size_t(e)] = 255.0f * coded;
    }
  }

  // dither: in [0, 1), fixed per pixel, so that skies show no steps.
  std::uint8_t operator()(float light, float dither) const {
    const float e = std::min(std::sqrt(std::max(light, 0.0f)) * (entries / most), entries - 0.01f);
    const int low = int(e);
    const float coded = mix(table_[std::size_t(low)], table_[std::size_t(low) + 1], e - float(low));
    return std::uint8_t(std::min(coded + dither, 255.0f));
  }

 private:
  static constexpr int entries = 1024;
  static constexpr float most = 3.0f;  // root of the brightest light in the table
  std::vector<float> table_;
};

}  // namespace neve::render
