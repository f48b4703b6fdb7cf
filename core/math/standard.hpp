// What the physics takes from the standard library. Every header that is compiled for a device includes this one and no
// other of the library: run-time compilers of device code have none, and get the few names that are used from device.hpp.
#pragma once

#if defined(__CUDACC_RTC__)
#include "math/device.hpp"
#else
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#endif
