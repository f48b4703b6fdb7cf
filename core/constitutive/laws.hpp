// The constitutive laws that a scene can choose. All that names them follows from this list.
#pragma once

#include "constitutive/cam_clay.hpp"
#include "constitutive/drucker_prager.hpp"
#include "constitutive/neo_hookean.hpp"
#include "constitutive/stomakhin2013.hpp"

namespace neve {

using Laws = List<Stomakhin2013, NeoHookean, Hencky, DruckerPrager, CamClay>;

// f(Law{}) for the law at that place of the list.
template <class F>
NEVE_INLINE auto with_law(int law, F&& f) {
  return pick(Laws{}, law, f);
}

// How far one step may compress the snow, -dt tr grad v [1]; `strongest`: the largest factor on its thresholds.
inline double max_compression(const Snow& snow, double strongest) {
  return with_law(snow.law, [&](auto law) {
    using Law = decltype(law);
    if (!snow.plastic) return std::numeric_limits<double>::infinity();
    return Law::max_compression(snow.constants<typename Law::Constants>(), strongest);
  });
}

}  // namespace neve
