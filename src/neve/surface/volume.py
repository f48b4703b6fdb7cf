"""Density of the snow on a sparse grid, spread with the kernel of the simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve._surface import Field

Floats = NDArray[np.float32]
SIDE = 4
"""Cells of a block along each axis."""


@dataclass(frozen=True)
class SparseVolume:
    """Hold numbers at the centres of cells, in blocks of 4x4x4; elsewhere they are zero.

    Cell (i, j, k) of block b has its centre at origin + (4 blocks[b] + (i, j, k) + 1/2) cell_size.
    blocks (b, 3); values (b, 4, 4, 4); origin (3,) and cell_size [m]
    """

    blocks: NDArray[np.int32]
    values: Floats
    origin: tuple[float, float, float]
    cell_size: float

    @property
    def total(self) -> float:
        """The integral of the numbers over space, in their unit times m3."""
        return float(self.values.sum(dtype=np.float64)) * self.cell_size**3

    def dense(self) -> tuple[Floats, NDArray[np.float64]]:
        """Return the numbers (nx, ny, nz) on the smallest box of whole blocks, and its lowest corner [m]."""
        if not len(self.blocks):
            return np.zeros((0, 0, 0), np.float32), np.asarray(self.origin, np.float64)
        low = self.blocks.min(axis=0)
        count = self.blocks.max(axis=0) - low + 1
        out = np.zeros((*count, SIDE, SIDE, SIDE), np.float32)
        out[tuple((self.blocks - low).T)] = self.values
        corner = np.asarray(self.origin, np.float64) + low * (SIDE * self.cell_size)
        return out.transpose(0, 3, 1, 4, 2, 5).reshape(count * SIDE), corner


def volume_of(field: Field) -> SparseVolume:
    """Copy a field into arrays; blocks that hold nothing are left out."""
    values = field.values()
    held = values.any(axis=(1, 2, 3))
    return SparseVolume(field.blocks()[held], values[held], field.origin, field.cell_size)


def density_and_momentum(
    x: NDArray[Any], mass: float | NDArray[Any], v: NDArray[Any], cell_size: float
) -> tuple[Field, Floats]:
    """Return the density of snow [kg/m3] and, on its blocks, its momentum (b, 4, 4, 4, 3) [kg/(m2 s)].

    rho_i = sum_p m_p w_ip / cell_size^3 and (rho u)_i = sum_p m_p v_p w_ip / cell_size^3, w the quadratic
    B-spline.

    x: positions (n, 3) [m]; mass: of each particle (n,) or of every one [kg]; v (n, 3) [m/s]; cell_size [m]:
    the grid spacing of a run gives the density that its grid sees. Particles that are not finite are left
    out.

    Errors: ValueError for a cell size that is not above zero.
    """
    return Field.moments(points(x), amounts(mass) / np.float32(cell_size**3), points(v), cell_size)


def points(x: NDArray[Any]) -> Floats:
    """Return positions as the compiled part reads them."""
    return np.ascontiguousarray(x, np.float32).reshape(-1, 3)


def amounts(a: float | NDArray[Any]) -> Floats:
    """Return one number for all points, or one for each, as the compiled part reads them."""
    return np.ascontiguousarray(np.atleast_1d(a), np.float32)
