// Threads of a block as fibers of one thread of the processor: each has its own stack and runs until it hands over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>
#if !defined(__x86_64__)
#include <ucontext.h>
#endif

namespace shim {

inline constexpr std::size_t stack_bytes = 64 * 1024;

#if defined(__x86_64__)
// Keep the registers that a callee keeps on the stack, change stacks, and go on there (System V calling convention).
extern "C" void shim_switch(void** from, void* to);
asm(R"(
  .text
  .globl shim_switch
  .type shim_switch, @function
shim_switch:
  pushq %rbp
  pushq %rbx
  pushq %r12
  pushq %r13
  pushq %r14
  pushq %r15
  movq %rsp, (%rdi)
  movq %rsi, %rsp
  popq %r15
  popq %r14
  popq %r13
  popq %r12
  popq %rbx
  popq %rbp
  ret
  .size shim_switch, .-shim_switch
)");
using Context = void*;
inline void switch_to(Context& from, Context& to) { shim_switch(&from, to); }
inline void prepare(Context& context, char* stack, void (*entry)(), Context&) {
  auto top = (reinterpret_cast<std::uintptr_t>(stack) + stack_bytes) & ~std::uintptr_t(63);
  auto* word = reinterpret_cast<std::uintptr_t*>(top) - 2;  // the entry sees a stack as after a call
  *word = reinterpret_cast<std::uintptr_t>(entry);
  for (int k = 0; k < 6; ++k) *--word = 0;
  context = word;
}
#else
using Context = ucontext_t;
inline void switch_to(Context& from, Context& to) { swapcontext(&from, &to); }
inline void prepare(Context& context, char* stack, void (*entry)(), Context& then) {
  getcontext(&context);
  context.uc_stack.ss_sp = stack, context.uc_stack.ss_size = stack_bytes, context.uc_link = &then;
  makecontext(&context, entry, 0);
}
#endif

}  // namespace shim
