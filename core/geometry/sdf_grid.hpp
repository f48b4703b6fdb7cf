// The signed distance of a solid on a sparse grid, with its samples.
#pragma once

#include <vector>

#include "geometry/sdf_view.hpp"

namespace neve {

struct SdfGrid : SdfLattice {
  double thickness = 0;             // above 0: phi is the distance less half of this [m]
  double openness = 0;              // share of the samples near the surface that are neither in nor out [1]
  std::vector<std::int32_t> table;  // as in SdfView
  std::vector<float> coarse, fine;

  SdfView view() const {
    SdfView out;
    static_cast<SdfLattice&>(out) = *this;
    out.table = table.data(), out.coarse = coarse.data(), out.fine = fine.data();
    return out;
  }
  std::size_t bytes() const {
    return sizeof(*this) + table.size() * sizeof(std::int32_t) +
           (coarse.size() + fine.size()) * sizeof(float);
  }
};

}  // namespace neve
