"""How snow grew while it fell: its particles, each with the moment at which it lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.snowfall.cover import Cover

Array = NDArray[np.float64]

JITTER = 0.8
"""Width of the random places of particles, in their distances."""


@dataclass(frozen=True, eq=False)
class Growth:
    """Hold particles that fill the deepest snow of each place.

    Attributes:
        x: places [m], (m, 3)
        height: above the surface at which each appears [m], (m,)
        site: the place that each lies on, (m,)
        depths: of the snow on each place before the first part and after each (k + 1, n) [m]
    """

    x: Array
    height: Array
    site: NDArray[np.int64]
    depths: Array

    @classmethod
    def of(cls, cover: Cover, depths: Array, spacing: float, seed: int) -> Growth:
        """Return the particles of a cover that had these depths; spacing: about their distance [m].

        They stand in columns. Each appears where the snow reaches its height, which is random within its
        distance, so that a dusting comes first. Equal arguments give equal bits.
        """
        rng = np.random.default_rng([seed, len(cover.z)])
        parts = max(1, round(cover.raster.cell / spacing))
        width = cover.raster.cell / parts
        deepest = depths.max(axis=0)
        rows = np.repeat(np.flatnonzero(deepest > 0.0), parts * parts)
        count = np.ceil(deepest[rows] / width).astype(np.int64)
        column = np.repeat(np.arange(len(rows)), count)
        level = np.arange(len(column)) - np.repeat(np.cumsum(count) - count, count)
        site = rows[column]
        jitter = rng.random((len(column), 3)) - 0.5
        place = np.stack(np.divmod(column % (parts * parts), parts), axis=1)
        offset = (place + 0.5 + JITTER * jitter[:, :2]) * width - 0.5 * cover.raster.cell
        x = cover.x[site]
        x[:, :2] += offset
        x[:, 2] = cover.z[site] + np.sum(offset * cover.columns.slope()[site], axis=1)
        x[:, 2] += (level + 0.5 + JITTER * jitter[:, 2]) * width
        return cls(x, (level + 0.5 + jitter[:, 2]) * width, site, depths)

    def at(self, share: float) -> NDArray[np.int64]:
        """Return which particles lie when `share` of the fall is over [1]; parts fall evenly."""
        last = len(self.depths) - 1
        done = min(max(share, 0.0), 1.0) * last
        k = min(int(done), last - 1)
        depth = self.depths[k] + (done - k) * (self.depths[k + 1] - self.depths[k])
        return np.flatnonzero(self.height < depth[self.site])
