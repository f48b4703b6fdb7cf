// What the stand-in loads instead of machine code: the kernels of the choice that SHIM_CHOICE names.
#include "module.hpp"

extern "C" void shim_fill(shim::Module* out) { *out = shim::module_of<neve::cuda::Choice<SHIM_CHOICE>>(); }
