"""State: everything per particle that changes or travels with it. The State is the checkpoint.

The arrays of FIELDS live in the core (`neve._core.State`) and are seen from NumPy without a copy. Rows change
places when the core sorts them; `id` says which particle a row is. A view stays valid until the number of
particles changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import determinant
from neve.solver import Field, fill_columns

if TYPE_CHECKING:
    from neve._core import Model, Precision, State


FIELDS = (
    Field("x", (3,), "m", "real", "position"),
    Field("beyond", ("k",), "m", "real", "far from the origin: to be added to x, less than its rounding"),
    Field("v", (3,), "m/s", "real", "velocity"),
    Field("C", (3, 3), "1/s", "real", "affine velocity, zero with transfers that have none"),
    Field(
        "modes",
        ("k", 3),
        "m/s",
        "real",
        "further modes of the velocity; lift off slip [m]",
    ),
    Field("rest", ("k",), "s, m/s", "real", "time at rest, infinite in sleep; mean velocity of late"),
    Field("enthalpy", ("k",), "J", "float64", "with heat: zero for ice at the melting point"),
    Field("thermal", ("k",), "1", "real", "with heat: share of water, growth by sintering, most water ever"),
    Field("F_E", (3, 3), "1", "real", "elastic deformation gradient"),
    Field("J_P", (), "1", "real", "plastic volume change"),
    Field("m", (), "kg", "real", "mass"),
    Field("V0", (), "m3", "real", "volume at rest"),
    Field("stiffness", (), "1", "real", "factor on E0"),
    Field("strength", (), "1", "real", "factor on the thresholds of plastic flow"),
    Field("material", (), "", "uint16", "row of the material table"),
    Field("id", (), "", "uint32", "number in the order of birth"),
)
"""All that a particle owns. The stress tau is left out: it follows from F_E and J_P."""

REST_NUMBERS = 4
"""Numbers of `rest` where snow may sleep; elsewhere there are none."""
BEYOND_NUMBERS = 3
"""Numbers of `beyond` where positions are fine; elsewhere there are none."""


def to_arrays(state: State) -> dict[str, NDArray[Any]]:
    """Copy the state into plain arrays, rows in the core's order."""
    return {field.name: np.array(getattr(state, field.name)) for field in FIELDS}


def from_arrays(core: Precision, arrays: Mapping[str, NDArray[Any]], **others: NDArray[Any]) -> State:
    """Make a state from the arrays of `to_arrays`; `others`, by name, take the place of theirs.

    Errors: ValueError for an array of another shape, or of numbers of another kind.
    """
    columns = {field.name: arrays[field.name] for field in FIELDS}  # one by one: it may say what it lacks
    columns |= others
    rest, heat, fine = (columns[name].shape[1] > 0 for name in ("rest", "thermal", "beyond"))
    state = core.State(len(columns["m"]), columns["modes"].shape[1], rest, heat, fine)
    fill_columns(state, FIELDS, columns)
    return state


def fit_numbers(numbers: NDArray[Any], count: int, has: bool, like: NDArray[Any]) -> NDArray[Any]:
    """Return a field (n, k) of the particles `like` (n, ...) as a run needs it that has it, or has not.

    count: k of a run that has it. From a run of the other kind it comes as zeros, or is left out: so all
    begin to rest anew.
    """
    if numbers.ndim == 2 and numbers.shape[1] == count * (not has):
        return np.zeros((len(like), count * has), like.dtype)
    return numbers


def fit_modes(modes: NDArray[Any], polynomial: int, native: Model) -> NDArray[Any]:
    """Return `modes` (n, k, 3) as the core's model needs them; what is new is zero.

    polynomial: how many of the k rows are modes of the velocity; one more may be
        how far the snow has left surfaces with play [m].
    """
    needed = native.more_modes - native.has_play
    out = np.zeros((len(modes), native.more_modes, 3), modes.dtype)
    kept = min(needed, polynomial)
    out[:, :kept] = modes[:, :kept]
    if native.has_play and modes.shape[1] > polynomial:
        out[:, needed] = modes[:, polynomial]
    return out


def density(state: State) -> NDArray[Any]:
    """Return m / (V0 det(F_E) J_P), the density of each particle [kg/m3], (n,)."""
    J = determinant(state.F_E) * state.J_P
    return np.asarray(state.m / (state.V0 * np.maximum(J, 1e-3)))
