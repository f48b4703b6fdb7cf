"""Melt water in pictures: what of it lies on the ground, and how deep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve._surface import Field
from neve.surface.volume import amounts, points

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose

Floats = NDArray[np.float32]

WATER = 0.95
"""Liquid share from which a particle is water, not slush [1]."""
LYING = 1.2
"""Height over the ground below which water lies on it, in particle spacings."""
BLURS = 5
"""Times that the depth of a puddle is blurred with (1, 2, 1) / 4: a deviation of 1.6 spacings. A particle on
the ground is water that has spread."""
MOST = 2048
"""Cells of a puddle along each side at most; water farther out is left out."""
WIDTH = 3.0
"""Cells of the grid that tells whether there is snow around, in particle spacings."""
SHARE = WIDTH**-3
"""What a particle fills of such a cell [1]."""
AMONG = 0.002
"""Share of its room that snow fills, from which water soaks it instead of flying [1]."""
LEAST_WET, MOST_WET = 0.01, 0.98
"""Wetness of snow below which it is drawn as dry, and that it has at most [1]."""
DAMP = 6e-4
"""Depth of water at which ground is wet [m]: it then is 1 - 1/e of the way to as dark as it gets."""


@dataclass(frozen=True)
class Puddle:
    """Hold the depth of water on a plane [m], (nu, nv), at the middles of square cells.

    origin (2,): corner of the first cell in the plane's own axes [m]; cell: their side [m]
    """

    origin: NDArray[np.float64]
    cell: float
    depth: Floats

    def at(self, u: NDArray[Any], v: NDArray[Any]) -> Floats:
        """Return the depth [m] at places u, v [m] of the plane, linear between the middles; 0 outside."""
        a = (np.asarray(u) - self.origin[0]) / self.cell - 0.5
        b = (np.asarray(v) - self.origin[1]) / self.cell - 0.5
        rows, columns = self.depth.shape
        inside = (a >= 0) & (b >= 0) & (a < rows - 1) & (b < columns - 1)
        a, b = np.where(inside, a, 0.0), np.where(inside, b, 0.0)
        i, j = a.astype(np.int64), b.astype(np.int64)
        s, t = a - i, b - j
        d = self.depth
        low = d[i, j] * (1 - t) + d[i, j + 1] * t
        high = d[i + 1, j] * (1 - t) + d[i + 1, j + 1] * t
        return np.asarray(np.where(inside, low * (1 - s) + high * s, 0.0), np.float32)

    @property
    def wet(self) -> Floats:
        """How wet the plane is in each cell, (nu, nv): 1 - exp(-depth / DAMP) [1]."""
        return np.asarray(-np.expm1(-self.depth / np.float32(DAMP)), np.float32)

    def wetness(self, u: NDArray[Any], v: NDArray[Any]) -> Floats:
        """Return how wet the plane is at places u, v [m], see `wet`."""
        return np.asarray(-np.expm1(-self.at(u, v) / np.float32(DAMP)), np.float32)


def mean_at(places: NDArray[Any], x: NDArray[Any], values: NDArray[Any], spacing: float) -> Floats:
    """Return means (m,) at places (m, 3) of the values (n,) of particles at x (n, 3) [m].

    They are sum_p w_p values_p / sum_p w_p, w the blurred quadratic B-spline of the width `spacing` [m]; 0
    where there are none.
    """
    here, where = points(places), points(x)
    if not (len(here) and len(where)):
        return np.zeros(len(here), np.float32)
    total = Field(where, amounts(1.0), spacing, 1).sample(here)
    part = Field(where, amounts(values), spacing, 1).sample(here)
    return np.asarray(part / np.maximum(total, 1e-6), np.float32)


@dataclass(frozen=True)
class Water:
    """Hold what melting has made of the particles of a frame that do not lie on the ground.

    rows (n,): which of the frame's these are. share (n,): liquid share; volume (n,): of its snow and water
    over that of its snow at birth [1]; flies, soaks (n,): whether it is water with hardly any snow around, or
    water within snow. puddles: by the number of the plane that they lie on
    """

    rows: NDArray[np.int64]
    share: Floats
    volume: Floats
    flies: NDArray[np.bool_]
    soaks: NDArray[np.bool_]
    puddles: dict[int, Puddle]

    def wetness_at(self, places: NDArray[Any], x: NDArray[Any], spacing: float) -> Floats:
        """Return how wet snow is at places (m, 3), 0 to 1: the mean liquid share of what does not fly.

        x (n, 3) [m]: of all particles of the frame; spacing of these in snow at rest [m].
        """
        near = ~self.flies
        return mean_at(places, np.asarray(x)[self.rows[near]], self.share[near], spacing)

    def wetness(self, x: NDArray[Any], spacing: float) -> Floats:
        """Return how wet each particle is that does not soak: 1 is a drop; the others are less.

        x (n, 3) [m]: of all particles of the frame; spacing of these in snow at rest [m].
        """
        own = ~self.soaks
        places = np.asarray(x)[self.rows[own]]
        found = np.minimum(self.wetness_at(places, x, spacing), MOST_WET)
        found[found < LEAST_WET] = 0.0
        return np.where(self.flies[own], np.float32(1.0), found)


def melt_water(
    solids: Sequence[tuple[Solid, Pose]],
    x: NDArray[Any],
    water: NDArray[Any],
    J_P: NDArray[Any] | None,
    spacing: float,
) -> Water | None:
    """Return what melting has made of the particles of a frame; None if it has made nothing.

    solids: and where they are; x (n, 3) [m]; water (n,): liquid shares; J_P (n,): volumes over those at
    birth; spacing of particles in snow at rest [m].
    """
    share = np.asarray(water, np.float32)
    if not share.any():
        return None
    volume = np.ones(len(x), np.float32) if J_P is None else np.minimum(J_P, 1.0).astype(np.float32)
    volume = 1.0 + (volume - 1.0) * share
    lying = lying_on(solids, x, share, spacing)
    puddles = {
        k: puddle_of(solids[k][1], x[rows], volume[rows] * spacing**3, spacing) for k, rows in lying.items()
    }
    kept = np.ones(len(x), np.bool_)
    for rows in lying.values():
        kept[rows] = False
    liquid = share >= WATER
    snow = points(x[~liquid])
    around = Field(snow, amounts(SHARE), WIDTH * spacing).sample(points(x)) if len(snow) else 0.0
    rows = np.flatnonzero(kept)
    flies, soaks = (liquid & (around < AMONG))[rows], (liquid & (around >= AMONG))[rows]
    return Water(rows, share[rows], volume[rows], flies, soaks, puddles)


def lying_on(
    solids: Sequence[tuple[Solid, Pose]], x: NDArray[Any], water: NDArray[Any], spacing: float
) -> dict[int, NDArray[np.int64]]:
    """Return the rows of the particles that are water lying on a plane, by its number in `solids`.

    x (n, 3) [m]; water (n,): liquid shares; spacing of particles in snow at rest [m].
    """
    found: dict[int, NDArray[np.int64]] = {}
    rows = np.flatnonzero((np.asarray(water) >= WATER) & np.isfinite(x).all(axis=1))
    for k, (solid, pose) in enumerate(solids):
        if not (len(rows) and solid.endless and solid.visible):
            continue
        height = (x[rows] - pose.position) @ pose.rotation[:, 2]
        low = height < LYING * spacing
        if low.any():
            found[k] = rows[low]
        rows = rows[~low]
    return found


def puddle_of(pose: Pose, x: NDArray[Any], volume: NDArray[Any], spacing: float) -> Puddle:
    """Return the puddle on a plane at `pose` of particles at x (n, 3) [m], each `volume` (n,) [m3] of water.

    spacing of particles in snow at rest [m]: as large as a cell. The integral of the depth is the volume of
    those that are not left out.
    """
    at = ((np.asarray(x, np.float64) - pose.position) @ pose.rotation)[:, :2]
    amount = np.broadcast_to(volume, len(x))
    near = np.abs(at - np.median(at, axis=0)).max(axis=1) < 0.5 * MOST * spacing
    at, amount = at[near], amount[near]
    low = np.floor(at.min(axis=0) / spacing) - BLURS - 1
    cells = np.floor(at / spacing - low).astype(np.int64)
    shape = cells.max(axis=0) + BLURS + 2
    flat = np.bincount(cells[:, 0] * shape[1] + cells[:, 1], amount, int(shape.prod()))
    depth = flat.reshape(shape) / spacing**2
    for _ in range(BLURS):
        for axis in (0, 1):
            wide = np.pad(depth, [(1, 1) if a == axis else (0, 0) for a in (0, 1)])
            side = wide.take(range(shape[axis]), axis) + wide.take(range(2, shape[axis] + 2), axis)
            depth = 0.5 * depth + 0.25 * side
    return Puddle(low * spacing, spacing, depth.astype(np.float32))
