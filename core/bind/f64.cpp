#include "bind/precision.hpp"

namespace neve::bind {
void bind_f64(nb::module_& m) { bind_precision<double>(m); }
}  // namespace neve::bind
