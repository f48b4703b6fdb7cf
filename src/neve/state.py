"""State: everything per particle that changes or travels with it. The State is the checkpoint.

The arrays live in the core (`neve._core.State`) and are seen from NumPy without a copy:

    x (n, 3) position [m]            F_E (n, 3, 3) elastic deformation gradient [1]
    v (n, 3) velocity [m/s]          J_P (n,) plastic volume change [1]
    C (n, 3, 3) affine velocity [1/s]    modes (n, k, 3) further modes of the velocity [m/s], if any
    m (n,) mass [kg], V0 (n,) rest volume [m3]
    stiffness (n,) factor on E0 [1]  strength (n,) factor on the thresholds of plastic flow [1]
    material (n,) row of the material table, id (n,) birth number

Rows change places when the core sorts them; `id` says which particle a row is. A view stays valid until the
number of particles changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from neve._core import Precision, State


FIELDS = ("x", "v", "C", "modes", "F_E", "J_P", "m", "V0", "stiffness", "strength", "material", "id")
"""All that a particle owns. The stress tau is left out: it follows from F_E and J_P."""


def to_arrays(state: State) -> dict[str, NDArray[Any]]:
    """Copy the state into plain arrays, rows in the core's order."""
    return {name: np.array(getattr(state, name)) for name in FIELDS}


def from_arrays(core: Precision, arrays: Mapping[str, NDArray[Any]]) -> State:
    """Make a state from the arrays of `to_arrays`."""
    state = core.State(len(arrays["m"]), arrays["modes"].shape[1])
    for name in FIELDS:
        getattr(state, name)[...] = arrays[name]
    return state
