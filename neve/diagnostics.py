"""Sums over the snow: mass, momentum, energies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.model import Model

if TYPE_CHECKING:
    from neve._core import Grid, State


@dataclass(frozen=True)
class Diagnostics:
    """Hold the sums over all particles at one instant, added up in double precision in a fixed order.

    mass [kg], momentum (3,) [kg m/s], kinetic, elastic and potential energy [J], numbers of particles and of
    allocated blocks. The potential is -m g . x; the kinetic energy is that of the particles' velocities,
    without the affine part of APIC. `given` is the kinetic energy that contacts with colliders have given to
    the snow so far, negative where they took some.
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    elastic: float
    potential: float
    given: float
    particles: int
    blocks: int


def diagnose(model: Model, state: State, grid: Grid, exchanged: NDArray[np.float64]) -> Diagnostics:
    """Add up the state; `exchanged` is that of the Simulation."""
    t = model.core.totals(model.native, state)
    px, py, pz = t.momentum
    return Diagnostics(
        mass=t.mass,
        momentum=(px, py, pz),
        kinetic=t.kinetic,
        elastic=t.elastic,
        potential=t.potential,
        given=float(exchanged[:, 6].sum()),
        particles=int(state.count),
        blocks=int(grid.blocks),
    )
