// The kernels for one Choice, which NVRTC compiles: the macro NEVE_CHOICE names its eight arguments.
#include "cuda/kernels.hpp"

namespace neve::cuda {
using C = Choice<NEVE_CHOICE>;
using T = C::T;
static_assert(sizeof(Step<T>) == NEVE_STEP_BYTES, "the host and the device see another Step");
}  // namespace neve::cuda

#define NEVE_ENTRY(name, threads, function)                                       \
  extern "C" __global__ void __launch_bounds__(neve::cuda::threads)               \
      neve_##name(const __grid_constant__ neve::cuda::Step<neve::cuda::T> step) { \
    using namespace neve::cuda;                                                   \
    neve::cuda::function(step);                                                   \
  }
NEVE_KERNELS(NEVE_ENTRY)
