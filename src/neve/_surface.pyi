"""Make fields, surfaces and grains of particles: the compiled part of `neve.surface`.

Lengths in metres. Arrays are read in C order and copied.
"""

import numpy as np
from numpy.typing import NDArray

class Field:
    """A scalar on a sparse grid of cells, in blocks of 4x4x4; zero where there is no block.

    x (n, 3) [m], those that are not finite are left out; amounts: (n,), or (1,) for all; cell_size [m];
    blurs: how often the grid is blurred with (1, 2, 1) / 4 along each axis, 0 to 8.
    Errors: ValueError for other sizes.
    """

    def __init__(
        self, x: NDArray[np.float32], amounts: NDArray[np.float32], cell_size: float, blurs: int = 0
    ) -> None:
        """Spread the amounts over the cells with quadratic B-splines, whose weights sum to one."""
    @staticmethod
    def balls(x: NDArray[np.float32], amounts: NDArray[np.float32], radius: float, cell_size: float) -> Field:
        """Add up amount * wyvill(distance / radius) of balls at centres of cells; R up to 64 cells."""
    @staticmethod
    def stretched(
        x: NDArray[np.float32],
        amounts: NDArray[np.float32],
        stretch: NDArray[np.float32],
        width: float,
        cell_size: float,
        blurs: int = 0,
    ) -> Field:
        """Add up kernels prod_k N((S^-1 (x - x_p))_k / width), N the quadratic B-spline, each of sum one.

        stretch: S, symmetric and positive (n, 3, 3); width [m]. With S = 1 and width = cell_size it is
        `Field(x, amounts, cell_size, blurs)`. Errors: ValueError for other sizes, or kernels that reach
        further than 64 cells.
        """
    @staticmethod
    def moments(
        x: NDArray[np.float32], amounts: NDArray[np.float32], v: NDArray[np.float32], cell_size: float
    ) -> tuple[Field, NDArray[np.float32]]:
        """Return the field of the amounts and, on its blocks, that of amounts v (n, 3): (b, 4, 4, 4, 3)."""
    @property
    def cell_size(self) -> float:
        """Edge of a cell [m]."""
    @property
    def origin(self) -> tuple[float, float, float]:
        """Corner [m] of cell (0, 0, 0), which is the first one of block (0, 0, 0)."""
    def blocks(self) -> NDArray[np.int32]:
        """Return the place of each block (b, 3), in blocks."""
    def values(self) -> NDArray[np.float32]:
        """Return the values of the cells of each block, (b, 4, 4, 4)."""
    def sample(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the value (n,) at points (n, 3), linear between the centres of cells."""
    def surface(self, level: float) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int32]]:
        """Return vertices (n, 3), normals (n, 3) and faces (m, 3) of the closed surface of that value.

        Errors: ValueError for a level that is not above zero.
        """

def grains(
    x: NDArray[np.float32],
    id: NDArray[np.int64],
    lone: NDArray[np.float32],
    offset: NDArray[np.float32],
    spacing: float,
    count: int,
) -> NDArray[np.float32]:
    """Return the grains (n * count, 3) of particles, one particle after the other.

    x (n, 3) [m]; id (n,); lone (n,): 0 among others, 1 alone; offset: matrices that move the places of grains
    beside their particle, (n, 3, 3), or (1, 3, 3) for all; spacing: of particles at rest [m]; count: 1 to
    512.
    Errors: ValueError for other sizes.
    """

def gradients(
    first: NDArray[np.float32], x: NDArray[np.float32], near: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Return the deformation gradients (n, 3, 3) that move the neighbours of each particle best.

    first, x (n, 3) [m]: places before and now, not finite where a particle is gone; near (n, k): rows of the
    neighbours. Errors: ValueError for other sizes or rows.
    """

def carried(F: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return of deformation gradients F (n, 3, 3) the rotations R, F = R S, and R S with S between 0.65 and
    1.5, both (n, 3, 3)."""
