// Sums that many threads add to: in double, or so that their bits depend on no order.
#pragma once

#include "cuda/grid/views.hpp"

namespace neve::cuda {

// All bytes zero: nothing has been added.
template <bool deterministic>
struct Sum {
  double value;

  void clear() { value = 0; }
  void add(double a) {
    if (a != 0) atomicAdd(&value, a);
  }
  void add(const Sum& o) { add(o.value); }
};

// A sum of whole numbers, which is the same in any order: of units of 2^0, 2^-32, 2^-64 and 2^-96, each in 64 bits, so that
// 2^31 numbers of up to 2^62 can be added. What is below 2^-96 = 1.3e-29 is cut off (Kulisch's long accumulator, shortened).
template <>
struct Sum<true> {
  BlockKey part[sum_parts];

  void clear() {
    for (BlockKey& a : part) a = 0;
  }
  void add(double a) {
    constexpr double most = 4611686018427387904.0, next = 4294967296.0;
    if (!(abs(a) < most)) return;  // no finite number of any snow
    for (BlockKey& to : part) {
      const long long whole = (long long)(a);
      if (whole != 0) atomicAdd(&to, BlockKey(whole));
      a = (a - double(whole)) * next;
    }
  }
  void add(const Sum& o) {
    for (int k = 0; k < sum_parts; ++k) {
      if (o.part[k] != 0) atomicAdd(&part[k], o.part[k]);
    }
  }
};

}  // namespace neve::cuda
