#include "bind/precision.hpp"

namespace neve::bind {
void bind_f32(nb::module_& m) { bind_precision<float>(m); }
}  // namespace neve::bind
