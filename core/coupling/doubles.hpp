// Packs in double precision, to sum in.
#pragma once

#include "math/real.hpp"

namespace neve {

// The same numbers in double precision.
template <IsPack R>
struct DoublesOf<R> {
  using type = Wide<double, width<R>>;
};
template <IsPack R>
NEVE_INLINE Doubles<R> doubles(const R& a) {
  using D = Doubles<R>;
  using P = part_t<D>;
  alignas(64) scalar_t<R> numbers[width<R>];
  detail::store_registers(numbers, a);
  return each_part<register_count<D>>([&](int k) NEVE_INLINE_LAMBDA {
    return __builtin_convertvector(
        detail::load_registers<Pack<scalar_t<R>, width<P>>>(numbers + k * width<P>), P);
  });
}

}  // namespace neve
