// The kernels of one choice, each run by cuda.hpp.
#pragma once

#include <map>
#include <string>

#include "cuda.hpp"
#include "cuda/kernels.hpp"

namespace shim {

struct Function {
  std::string name;
  unsigned threads;
  std::size_t step_bytes;
  std::function<void(const void* step, unsigned blocks, unsigned threads, unsigned order)> launch;
};
using Module = std::map<std::string, Function>;

template <class C>
Module module_of() {
  using namespace neve::cuda;
  using T = typename C::T;
  Module out;
#define SHIM_ENTRY(name, most_threads, function)                                                 \
  out["neve_" #name] = {#name, unsigned(most_threads), sizeof(Step<T>),                          \
                        [](const void* step, unsigned blocks, unsigned threads, unsigned order) { \
                          const auto& given = *static_cast<const Step<T>*>(step);                \
                          shim::launch([&] { function(given); }, blocks, threads, order);         \
                        }};
  NEVE_KERNELS(SHIM_ENTRY)
  return out;
}

}  // namespace shim
