// The kernels for one Choice, which NVRTC compiles: the macro NEVE_CHOICE names its nine arguments.
#include "cuda/kernels.hpp"

namespace neve::cuda {
using C = Choice<NEVE_CHOICE>;
using T = C::T;
static_assert(sizeof(Step<T>) == NEVE_STEP_BYTES, "the host and the device see another Step");

// How many blocks of threads of a kernel a multiprocessor must be able to hold; 0: what the compiler thinks best. For compute
// capability 10.0 it would spill registers of g2p and body_response for the sake of a fourth block (NVRTC 13.5).
constexpr int resident([[maybe_unused]] const char* name) {
#if __CUDA_ARCH__ >= 1000
  const bool g2p = name[0] == 'g' && name[1] == '2' && name[2] == 'p',
             body = name[0] == 'b' && name[5] == 'r';
  if (C::has_solids && (g2p || body)) return 3;
#endif
  return 0;
}
}  // namespace neve::cuda

#define NEVE_ENTRY(name, threads, function)                                                      \
  extern "C" __global__ void __launch_bounds__(neve::cuda::threads, neve::cuda::resident(#name)) \
      neve_##name(const __grid_constant__ neve::cuda::Step<neve::cuda::T> step) {                \
    using namespace neve::cuda;                                                                  \
    neve::cuda::function(step);                                                                  \
  }
NEVE_KERNELS(NEVE_ENTRY)
