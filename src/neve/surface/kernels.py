"""Anisotropic kernels: those of particles that lie in a sheet are flat, so that its surface is, too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve._surface import Field
from neve.surface.volume import amounts, points

Floats = NDArray[np.float32]

REACH = 2.0
"""Distance of the neighbours of a particle that are looked at, in particle spacings."""
MOST = 48
"""Neighbours that are looked at, the nearest."""
FEWEST = 6
"""With fewer a kernel is a ball."""
RATIO = 4.0
"""Longest over shortest stretch of a kernel: k_r of the source."""
SMOOTHING = 0.0
"""Share of the way to the middle of its neighbours that a kernel is moved: lambda of the source, which has
0.9 or more. That takes 10 % off a block of 24x24x8 particles, and makes its sides hardly flatter."""
CHUNK = 65536
"""Particles worked on at once."""


@dataclass(frozen=True)
class Kernels:
    """Hold the kernels of particles: centres (n, 3) [m], and stretches (n, 3, 3), symmetric, of determinant
    one."""

    centres: Floats
    stretch: Floats

    def field(self, amount: float | NDArray[Any], width: float, cell_size: float, blurs: int = 0) -> Field:
        """Return the sum of the kernels; amount: of each (n,) or of every one; width, cell_size [m].

        Their integral is that of the amounts, whatever the stretches.
        """
        return Field.stretched(self.centres, amounts(amount), self.stretch, width, cell_size, blurs)


def kernels_of(x: NDArray[Any], spacing: float, smoothing: float = SMOOTHING) -> Kernels:
    """Return kernels that lie along the snow around each particle.

    With w_j = 1 - (|x_j - x_i| / r)^3 over the particles within r = `REACH` s, itself among them, the middle
    is m_i = sum w_j x_j / sum w_j, the centre (1 - lambda) x_i + lambda m_i, and the covariance
    C_i = sum w_j (x_j - m_i)(x_j - m_i)^T / sum w_j = R diag(l_k^2) R^T. The stretch is S_i = R diag(s_k) R^T
    with s_k = max(l_k, l_1 / `RATIO`), l_1 the longest, divided by their geometric mean: kernels keep their
    volume.

    x: positions (n, 3) [m], finite; spacing s: of particles at rest [m]; smoothing: lambda

    Source: Yu and Turk 2013, section 4 (from memory), who take l_k^2 for the lengths, and a constant for the
    mean.
    """
    from scipy.spatial import cKDTree

    places = points(x)
    centres = places.copy()
    stretch = np.tile(np.eye(3, dtype=np.float32), (len(places), 1, 1))
    if len(places) < 2:
        return Kernels(centres, stretch)
    tree, count = cKDTree(places), min(MOST, len(places))
    for first in range(0, len(places), CHUNK):
        some = slice(first, min(first + CHUNK, len(places)))
        far, near = tree.query(
            places[some], k=count, distance_upper_bound=REACH * spacing, workers=_core.threads()
        )
        w = np.where(np.isfinite(far), 1.0 - np.minimum(far / (REACH * spacing), 1.0) ** 3, 0.0)
        d = places[np.minimum(near, len(places) - 1)].astype(np.float64) - places[some, None]
        w /= w.sum(axis=1, keepdims=True)
        middle = np.einsum("ij,ijk->ik", w, d)
        d -= middle[:, None]
        C = np.einsum("ij,ijk,ijl->ikl", w, d, d)
        l2, R = np.linalg.eigh(C)
        length = np.sqrt(np.maximum(l2, l2[:, -1:] / RATIO**2))
        enough = (np.isfinite(far).sum(axis=1) > FEWEST) & (length[:, -1] > 1e-3 * spacing)
        length = np.where(enough[:, None], length, 1.0)
        length /= np.prod(length, axis=1, keepdims=True) ** (1.0 / 3.0)
        S = np.einsum("ikm,im,ilm->ikl", R, length, R)
        stretch[some] = np.where(enough[:, None, None], S, np.eye(3))
        centres[some] += (smoothing * middle).astype(np.float32)
    return Kernels(centres, stretch)
