// Densities of what snow is made of.
#pragma once

namespace neve {

inline constexpr double ice_density = 917;     // at 0 C [kg/m3]
inline constexpr double water_density = 1000;  // [kg/m3]

}  // namespace neve
