// Small functions of packs must be inlined: a call passes every register through memory. Compilers weigh a pack of two
// registers as twice the code and stop too early.
#pragma once

#define NEVE_INLINE [[gnu::always_inline]] inline
#define NEVE_INLINE_LAMBDA __attribute__((always_inline))  // between the parameters and the body
