// The transfers that a scene can choose. All that names them follows from this list.
#pragma once

#include "transfer/aflip.hpp"
#include "transfer/apic.hpp"
#include "transfer/asflip.hpp"
#include "transfer/flip.hpp"
#include "transfer/pic.hpp"
#include "transfer/polypic.hpp"

namespace neve {

using Transfers = List<Apic, Flip, Pic, PolypicOfModes, Asflip, Aflip>;

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
