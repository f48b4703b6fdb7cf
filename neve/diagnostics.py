"""Sums over the snow: mass, momentum, energies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from neve.model import Model

if TYPE_CHECKING:
    from neve._core import Grid, State


@dataclass(frozen=True)
class Diagnostics:
    """Hold the sums over all particles at one instant, added up in double precision in a fixed order.

    mass [kg], momentum (3,) [kg m/s], kinetic, elastic and potential energy [J], numbers of particles and of
    allocated blocks. The potential is -m g . x; the kinetic energy is that of the particles' velocities,
    without the affine part of APIC.
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    elastic: float
    potential: float
    particles: int
    blocks: int


def diagnose(model: Model, state: State, grid: Grid) -> Diagnostics:
    """Add up the state."""
    t = model.core.totals(model.native, state)
    px, py, pz = t.momentum
    return Diagnostics(
        t.mass, (px, py, pz), t.kinetic, t.elastic, t.potential, int(state.count), int(grid.blocks)
    )
