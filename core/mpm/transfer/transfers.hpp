// The transfers that a scene can choose. All that names them follows from this list.
#pragma once

#include "mpm/transfer/apic.hpp"
#include "mpm/transfer/asflip.hpp"
#include "mpm/transfer/flip.hpp"
#include "mpm/transfer/pic.hpp"
#include "mpm/transfer/polypic.hpp"

namespace neve {

using Transfers = List<Apic, Flip, Pic, PolypicOfModes, Asflip>;

// f(Transfer{}) for the transfer at that place of the list, with so many velocity modes if it comes with several.
template <class F>
NEVE_INLINE auto with_transfer(int transfer, int modes, F&& f) {
  return pick(Transfers{}, transfer, [&](auto found) {
    using Found = decltype(found);
    if constexpr (requires { Found::of_modes(modes, f); })
      return Found::of_modes(modes, f);
    else
      return f(found);
  });
}

}  // namespace neve
