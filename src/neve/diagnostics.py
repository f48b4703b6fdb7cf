"""Sums over the snow and over the bodies that it moves: mass, momentum, energies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

MECHANICS = (
    "mass",  # [kg]
    "momentum_x",  # [kg m/s]
    "momentum_y",
    "momentum_z",
    "kinetic",  # energies [J]
    "elastic",
    "potential",
    "affine",  # kinetic energy of the velocity field that each particle carries around itself
    "work",  # of the solids on the snow since the start
    "bodies_momentum_x",  # of the bodies that snow moves [kg m/s]
    "bodies_momentum_y",
    "bodies_momentum_z",
    "bodies_kinetic",  # their energies [J]
    "bodies_potential",
    "excess",  # growth of energy since the frame before that nothing accounts for; negative: dissipated
    "particles",
)
"""Columns of the log that every method of simulation here fills."""


@dataclass(frozen=True, kw_only=True)
class Diagnostics:
    """Hold the sums over all particles at one instant, added up in double precision in a fixed order.

    A method's own class adds what it alone has. mass [kg], momentum (3,) [kg m/s]; energies [J]: kinetic (of
    the particles' velocities), affine (of the velocity field that each particle carries around itself, with
    transfers that have one), elastic, potential (-m g . x); numbers of particles and of those that sleep.
    work [J]: of the solids on the snow so far, impulse times the velocity of the solid's surface.
    Of the rigid bodies: bodies_momentum (3,) [kg m/s], bodies_kinetic and bodies_potential [J].
    Of all snow that emitters added and sinks took out so far: mass [kg], momentum (3,) [kg m/s], energy [J].
    heat: enthalpy above that of ice at the melting point, heat_taken: from air and sun so far [J]; water:
    liquid mass [kg]; heat_speed [1]; all 0 without heat.
    """

    mass: float
    momentum: tuple[float, float, float]
    kinetic: float
    affine: float = 0.0
    elastic: float
    potential: float
    work: float
    particles: int
    asleep: int = 0
    bodies_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bodies_kinetic: float = 0.0
    bodies_potential: float = 0.0
    emitted_mass: float = 0.0
    emitted_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    emitted_energy: float = 0.0
    removed_mass: float = 0.0
    removed_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    removed_energy: float = 0.0
    heat: float = 0.0
    heat_taken: float = 0.0
    water: float = 0.0
    heat_speed: float = 0.0


def sums_of(totals: Any, exchanged: NDArray[np.float64], particles: int) -> dict[str, Any]:
    """Return the mechanics of the snow for `Diagnostics`: from the core's `totals` and what was exchanged."""
    px, py, pz = totals.momentum
    return {
        "mass": totals.mass,
        "momentum": (px, py, pz),
        "kinetic": totals.kinetic,
        "elastic": totals.elastic,
        "potential": totals.potential,
        "work": float(exchanged[:, 6].sum()),
        "particles": particles,
    }


def number(cell: str) -> float:
    """Read a cell of the log; an empty one is NaN."""
    return math.nan if not cell else float(cell)


def row_of(totals: Any, columns: Sequence[str]) -> dict[str, float]:
    """Return the values of columns of the log: attributes of `totals`, NAME_x of the vector NAME.

    But for "excess", which compares two rows.
    """
    values = {}
    for column in columns:
        vector, _, axis = column.rpartition("_")
        if axis in ("x", "y", "z"):
            values[column] = getattr(totals, vector)["xyz".index(axis)]
        elif column != "excess":
            values[column] = getattr(totals, column)
    return values


class Balance(NamedTuple):
    """Energies of the snow, work of the colliders, and energy that snow brought and took away so far [J].

    The names are those of the log's columns.
    """

    kinetic: float
    affine: float
    elastic: float
    potential: float
    work: float
    emitted_energy: float = 0.0
    removed_energy: float = 0.0

    @classmethod
    def of(cls, now: Any) -> Balance:
        """Take the balance from the diagnostics of one time, whose attributes have its names."""
        return cls(*(getattr(now, name, 0.0) for name in cls._fields))

    @classmethod
    def of_row(cls, row: Mapping[str, str]) -> Balance:
        """Read the balance from a row of the log; an empty cell is NaN, and a column that is not there 0."""
        return cls(*(number(row.get(name, "0")) for name in cls._fields))

    @property
    def came(self) -> float:
        """Energy that snow brought less what it took away so far [J]."""
        return self.emitted_energy - self.removed_energy

    @property
    def kinetic_and_elastic(self) -> float:
        """Sum of kinetic, affine and elastic energy [J]."""
        return self.kinetic + self.affine + self.elastic

    @property
    def total(self) -> float:
        """Sum of all energies of the snow [J]."""
        return self.kinetic_and_elastic + self.potential

    def growth(self, before: Balance) -> float:
        """Return what the snow gained since `before` beyond the colliders' work and what came with snow.

        A loss is below zero.
        """
        return self._unaccounted - before._unaccounted

    @property
    def _unaccounted(self) -> float:
        return self.total - self.work - self.came
