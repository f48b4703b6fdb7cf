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

    mass [kg], momentum (3,) [kg m/s]; energies [J]: kinetic (of the particles' velocities), affine (of the
    velocity field that each particle carries around itself, with transfers that have one), elastic, potential
    (-m g . x); numbers of particles and of allocated blocks. `work` [J] is what
    colliders have done on the snow so far: impulse times the velocity of the collider's surface.
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    affine: float
    elastic: float
    potential: float
    work: float
    particles: int
    blocks: int

    @property
    def energy(self) -> float:
        """All of the snow's energy [J]."""
        return self.kinetic + self.affine + self.elastic + self.potential


def diagnose(model: Model, state: State, grid: Grid, exchanged: NDArray[np.float64]) -> Diagnostics:
    """Add up the state; `exchanged` is that of the Simulation."""
    t = model.core.totals(model.native, state)
    px, py, pz = t.momentum
    return Diagnostics(
        mass=t.mass,
        momentum=(px, py, pz),
        kinetic=t.kinetic,
        affine=t.affine,
        elastic=t.elastic,
        potential=t.potential,
        work=float(exchanged[:, 6].sum()),
        particles=int(state.count),
        blocks=int(grid.blocks),
    )
