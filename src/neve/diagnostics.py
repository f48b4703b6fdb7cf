"""Sums over the snow and over the bodies that it moves: mass, momentum, energies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple


@dataclass(frozen=True)
class Diagnostics:
    """Hold the sums over all particles at one instant, added up in double precision in a fixed order.

    mass [kg], momentum (3,) [kg m/s]; energies [J]: kinetic (of the particles' velocities), affine (of the
    velocity field that each particle carries around itself, with transfers that have one), elastic, potential
    (-m g . x); numbers of particles and of allocated blocks. `work` [J] is what
    colliders have done on the snow so far: impulse times the velocity of the collider's surface.
    Of the rigid bodies: bodies_momentum (3,) [kg m/s], bodies_kinetic and bodies_potential [J].
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
    bodies_momentum: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bodies_kinetic: float = 0.0
    bodies_potential: float = 0.0


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
    """Energies of the snow and work of the colliders [J] at one moment, by the names of the log's columns."""

    kinetic: float
    affine: float
    elastic: float
    potential: float
    work: float

    @classmethod
    def of(cls, now: Diagnostics) -> Balance:
        """Take the balance from the diagnostics of one time."""
        return cls(now.kinetic, now.affine, now.elastic, now.potential, now.work)

    @classmethod
    def of_row(cls, row: Mapping[str, str]) -> Balance:
        """Read the balance from a row of the log; an empty cell is NaN."""
        return cls(*(number(row[name]) for name in cls._fields))

    @property
    def kinetic_and_elastic(self) -> float:
        """Sum of kinetic, affine and elastic energy [J]."""
        return self.kinetic + self.affine + self.elastic

    @property
    def total(self) -> float:
        """Sum of all energies of the snow [J]."""
        return self.kinetic_and_elastic + self.potential

    def growth(self, before: Balance) -> float:
        """Return what the snow gained since `before` beyond the colliders' work; a loss is below zero."""
        return (self.total - before.total) - (self.work - before.work)
