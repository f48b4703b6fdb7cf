"""Columns of snow: depth and mass of particles over the cells of a patch, as the game has its snow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GAP = 3.0
"""Gap in a column, in spacings of particles, above which what is over it lies or flies on its own."""


@dataclass(frozen=True)
class Patch:
    """Hold a grid of cells along and across a track: corner [m], side of a cell [m], numbers of cells."""

    along: float
    across: float
    cell: float
    nx: int
    ny: int

    @property
    def middles(self) -> tuple[Array, Array]:
        """Return the middles of the cells along (nx,) and across (ny,) [m]."""
        return (
            self.along + self.cell * (np.arange(self.nx, dtype=float) + 0.5),
            self.across + self.cell * (np.arange(self.ny, dtype=float) + 0.5),
        )

    def cells_of(self, x: Array) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """Return the number of the cell of each place (n, 2+) [m], and whether it is in the patch."""
        i = np.floor((x[:, 0] - self.along) / self.cell).astype(np.intp)
        j = np.floor((x[:, 1] - self.across) / self.cell).astype(np.intp)
        inside = (i >= 0) & (i < self.nx) & (j >= 0) & (j < self.ny)
        return i * self.ny + j, inside


class Columns(NamedTuple):
    """Hold the snow over the cells of a patch at one moment.

    top: height of the connected snow (nx, ny) [m], NaN where there is none. mass: particles of the connected
    snow times spacing^3 over the cell's area, its depth at the density of the start (nx, ny) [m].
    loose: whether each particle is above a gap (n,).
    """

    top: Array
    mass: Array
    loose: NDArray[np.bool_]


def patch_about(x: Array, cell: float) -> Patch:
    """Return the patch that covers the places `x` (n, 2+) [m] by cells of a side `cell` [m]."""
    low, high = x[:, :2].min(axis=0), x[:, :2].max(axis=0)
    first = np.floor(low / cell + 1e-6) * cell
    n = np.maximum(1, np.ceil((high - first) / cell - 1e-6).astype(int))
    return Patch(float(first[0]), float(first[1]), cell, int(n[0]), int(n[1]))


def floor_of(x: Array, patch: Patch, spacing: float) -> Array:
    """Return the height of the ground below the snow `x` (n, 3) in each cell (nx, ny) [m]; NaN: no snow."""
    number, inside = patch.cells_of(x)
    low = np.full(patch.nx * patch.ny, np.inf)
    np.minimum.at(low, number[inside], x[inside, 2] - 0.5 * spacing)
    return np.where(np.isfinite(low), low, np.nan).reshape(patch.nx, patch.ny)


def columns_of(x: Array, patch: Patch, floor: Array, spacing: float) -> Columns:
    """Return the columns of the particles `x` (n, 3) [m] over a ground `floor` (nx, ny) [m]."""
    number, inside = patch.cells_of(x)
    rows = np.flatnonzero(inside)
    order = rows[np.lexsort((x[rows, 2], number[rows]))]
    cell, z = number[order], x[order, 2]
    first = np.diff(cell, prepend=-1) > 0
    ground = np.nan_to_num(floor.ravel()[cell], nan=np.inf) + 0.5 * spacing
    gap = np.where(first, z - ground, np.diff(z, prepend=0.0)) > GAP * spacing
    gap |= first & ~np.isfinite(ground)
    broken = np.cumsum(gap)
    before = np.where(first, broken - gap, 0)
    apart = broken > np.maximum.accumulate(before)
    top = np.full(patch.nx * patch.ny, -np.inf)
    np.maximum.at(top, cell[~apart], z[~apart] + 0.5 * spacing)
    count = np.bincount(cell[~apart], minlength=len(top)).astype(np.float64)
    mass = count * (spacing**3 / patch.cell**2)
    loose = np.zeros(len(x), bool)
    loose[order[apart]] = True
    shape = (patch.nx, patch.ny)
    return Columns(np.where(np.isfinite(top), top, np.nan).reshape(shape), mass.reshape(shape), loose)
