"""Look at the particles before they are used: impossible values, and snow that is denser than ice."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from neve import _core
from neve.mpm.failures import name_of
from neve.mpm.model import Model
from neve.reproducible import determinant
from neve.scene.schema.scene import Scene
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve._core import State

ALLOWED = {
    "x": "finite numbers [m]",
    "beyond": "finite numbers [m]",
    "v": "finite numbers [m/s]",
    "C": "finite numbers [1/s]",
    "modes": "finite numbers [m/s]",
    "F_E": "a finite matrix whose determinant is above zero",
    "J_P": "a finite number above zero",
    "enthalpy": "a finite heat [J]",
    "thermal": "a share of water from 0 to 1, a growth of strength of at least 1, a share from 0 to 1",
    "m": "a finite mass above zero [kg]",
    "V0": "a finite volume above zero [m3]",
    "stiffness": "a finite factor above zero",
    "strength": "a finite factor of at least zero",
    "material": "a row of the material table",
}
"""What each field of a particle may hold."""

TOO_DENSE = 1.1
"""Density over that of ice from which on a run says so [1]."""


class Densest(NamedTuple):
    """The row of the densest snow with plastic flow (-1: none), and its density over its limit [1]."""

    row: int
    crowding: float


def inspect(model: Model, state: State) -> Densest:
    """Return the densest particle.

    Errors: Blowup, one sentence, for a value that no snow has: which particle, which field, what is allowed.
    """
    row, field, densest, crowding = model.core.inspect(model.native, state)
    if row < 0:
        return Densest(densest, crowding)
    given = np.asarray(getattr(state, field)[row]).tolist()
    allowed = f"from 0 to {len(model.snows) - 1}" if field == "material" else ALLOWED[field]
    what = f" (determinant {_J_E(state, row):.3g})" if field == "F_E" else ""
    raise Blowup(f"{name_of(model, state, row)}: state.{field} = {given}{what}; allowed is {allowed}")


def require_whole(model: Model, state: State) -> None:
    """Refuse a state that no run of this model leaves. Errors: ValueError: which particle, what is wrong."""
    ids = np.asarray(state.id)
    ordered = np.sort(ids)
    if len(twice := ordered[1:][ordered[1:] == ordered[:-1]]):
        raise ValueError(f"two particles have the number {twice[0]}")
    try:
        inspect(model, state)
    except Blowup as error:
        raise ValueError(str(error)) from error


def _J_E(state: State, row: int) -> float:
    return float(determinant(np.asarray(state.F_E[row], dtype=np.float64)))


def too_dense(scene: Scene, model: Model, state: State, densest: Densest, time: float) -> str:
    """Say that snow is denser than ice, "" if it is not: which source, how dense, what to change."""
    if densest.row < 0 or densest.crowding <= TOO_DENSE:
        return ""
    row = densest.row
    material = int(state.material[row])
    whose = [
        f"{name}.{i}"
        for name in ("sources", "emitters")
        for i, s in enumerate(getattr(scene, name))
        if model.snows.index(scene.snow_of(s)) == material
    ]
    volume = _J_E(state, row) * float(state.J_P[row])
    pressed = float(state.m[row]) / (float(state.V0[row]) * volume)
    place = ", ".join(f"{a:.3g}" for a in state.x[row])
    return (
        f"snow of {' or '.join(whose)} is pressed to {pressed:.0f} kg/m3 at t = {time:.3g} s, by particle "
        f"{int(state.id[row])} at ({place}) m; ice has {_core.ice_density:.0f} kg/m3: leave it more room, "
        f"press or throw it more slowly, or resolve it more finely (numerics.dx = {model.numerics.dx:g} m)"
    )
