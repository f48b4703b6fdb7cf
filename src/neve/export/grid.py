"""Density and velocity of the snow of a moment on a sparse grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.export.moment import Moment

Floats = NDArray[np.float32]

SIDE = 4
"""Cells of a block along each axis."""


@dataclass(frozen=True)
class SnowGrid:
    """Hold density and velocity at the centres of cells, in blocks of 4x4x4; elsewhere there is no snow.

    Cell (i, j, k) of block b has its centre at first + (4 blocks[b] + (i, j, k)) cell.

    Attributes:
        blocks: (b, 3)
        density: [kg/m3], whatever the unit of the file, (b, 4, 4, 4); 0 where there is no snow
        velocity: mass-weighted mean [units/s], (b, 4, 4, 4, 3)
        first: centre of cell (0, 0, 0) of block (0, 0, 0). cell: edge of a cell, in units of the file
    """

    blocks: NDArray[np.int32]
    density: Floats
    velocity: Floats
    first: NDArray[np.float64]
    cell: float

    def dense(self) -> tuple[Floats, Floats, NDArray[np.float64]]:
        """Return density (nx, ny, nz) and velocity (nx, ny, nz, 3) on a box, and its lowest centre."""
        low = self.blocks.min(axis=0) if len(self.blocks) else np.zeros(3, np.int32)
        count = self.blocks.max(axis=0) + 1 - low if len(self.blocks) else np.ones(3, np.int32)
        nx, ny, nz = (int(n) for n in count)
        density = np.zeros((nx, SIDE, ny, SIDE, nz, SIDE), np.float32)
        velocity = np.zeros((*density.shape, 3), np.float32)
        i, j, k = (self.blocks - low).T
        density[i, :, j, :, k] = self.density
        velocity[i, :, j, :, k] = self.velocity
        shape = SIDE * nx, SIDE * ny, SIDE * nz
        return density.reshape(shape), velocity.reshape(*shape, 3), self.first + SIDE * self.cell * low


def snow_grid(moment: Moment, cell: float, scale: float) -> SnowGrid:
    """Spread mass and momentum over cells by quadratic B-splines: rho = sum m w / V, u = sum m v w / sum m w.

    scale: units of the file in a metre; densities are per cubic metre whatever it is.
    """
    from neve.surface.volume import density_and_momentum

    field, velocity = density_and_momentum(moment.x, moment.mass * scale**3, moment.v, cell)
    density = field.values()
    np.divide(velocity, density[..., None], out=velocity, where=density[..., None] > 0)
    return SnowGrid(field.blocks(), density, velocity, np.asarray(field.origin) + 0.5 * cell, cell)
