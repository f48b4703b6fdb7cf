"""Metaballs: snow as the sum of overlapping balls of density (Nishita et al. 1997).

rho(x) = sum_k q_k f(|x - c_k| / R), f(a) = 1 - 22/9 a^2 + 17/9 a^4 - 4/9 a^6 up to a = 1, 0 beyond. It is an
implicit surface, where rho = T, and a volume that scatters light.

Source: Nishita, Iwasaki, Dobashi and Nakamae 1997 (balls of density as snow); the sextic is that of Wyvill,
McPheeters and Wyvill 1986, [M] the kernel that Nishita's group uses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve._surface import Field
from neve.surface.mesh import SurfaceMesh, mesh_of
from neve.surface.volume import SparseVolume, amounts, points, volume_of

Array = NDArray[np.float64]

RADIUS = 2.0
"""Radius of a ball in particle spacings: neighbours overlap enough for packed snow to be level."""

# int f(|x|) dx over the unit ball: 4 pi (1/3 - 22/45 + 17/63 - 4/81)
_INTEGRAL = 4.0 * math.pi * (1 / 3 - 22 / 45 + 17 / 63 - 4 / 81)
CHUNK = 4096


@dataclass(frozen=True)
class Metaballs:
    """Hold balls. centres (n, 3) [m]; radius R [m]; strength q (n,) or (1,), in the unit of the field."""

    centres: NDArray[np.float32]
    radius: float
    strength: NDArray[np.float32]

    def at(self, x: NDArray[Any]) -> Array:
        """Return rho (m,) at points x (m, 3) [m], from the formula itself."""
        from scipy.spatial import cKDTree

        tree = cKDTree(self.centres.astype(np.float64))
        each = np.broadcast_to(self.strength.astype(np.float64), len(self.centres))
        out = np.zeros(len(x))
        for first in range(0, len(x), CHUNK):
            some = np.asarray(x[first : first + CHUNK], np.float64)
            pairs = tree.sparse_distance_matrix(cKDTree(some), self.radius, output_type="coo_matrix")
            value = each[pairs.row] * kernel(pairs.data / self.radius)
            out[first : first + len(some)] = np.bincount(pairs.col, value, len(some))
        return out

    def field(self, cell_size: float) -> Field:
        """Return rho at the centres of cells of `cell_size` [m]. Errors: ValueError if R is over 64 cells."""
        return Field.balls(self.centres, self.strength, self.radius, cell_size)

    def volume(self, cell_size: float) -> SparseVolume:
        """Return rho as numbers on a sparse grid."""
        return volume_of(self.field(cell_size))

    def surface(self, level: float, cell_size: float) -> SurfaceMesh:
        """Return the closed surface on which rho is `level`."""
        return mesh_of(self.field(cell_size), level)


def kernel(a: NDArray[Any] | float) -> Array:
    """Return f(a) = 1 - 22/9 a^2 + 17/9 a^4 - 4/9 a^6 for distances a in radii, 0 beyond 1.

    f(0) = 1, f(1/2) = 1/2, f(1) = 0, and its slope is 0 at 0 and 1.
    """
    q = np.minimum(np.asarray(a, np.float64) ** 2, 1.0)
    return np.asarray(1.0 + q * (-22.0 + q * (17.0 - 4.0 * q)) / 9.0)


def surface_radius(level: float) -> float:
    """Return the radius a of the surface f(a) = level of one ball, in ball radii; f falls, so there is one.

    Errors: ValueError unless 0 < level < 1.
    """
    if not 0.0 < level < 1.0:
        raise ValueError(f"level is above 0 and below 1, not {level}")
    # 4 q^3 - 17 q^2 + 22 q - 9 (1 - level) = 0 has one root in (0, 1): f falls there
    roots = np.roots([4.0, -17.0, 22.0, -9.0 * (1.0 - level)])
    real = roots[np.abs(roots.imag) < 1e-9].real
    return math.sqrt(float(real[(real > 0.0) & (real < 1.0)][0]))


def snow_balls(x: NDArray[Any], spacing: float, radius: float = RADIUS) -> Metaballs:
    """Return a ball for each particle, of `radius` spacings, strong enough for rho = 1 in packed snow.

    q R^3 int f = s^3: what a particle takes up at rest. x (n, 3) [m]; spacing s [m].
    """
    strength = 1.0 / (_INTEGRAL * radius**3)
    return Metaballs(points(x), radius * spacing, amounts(strength))
