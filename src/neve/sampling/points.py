"""Scatter points evenly in a box: on a lattice, a jittered one, or with a least distance (Poisson disk)."""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import norms
from neve.reproducible import product as times

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

JITTER = 0.7
"""Width of the random shift in units of the lattice spacing; neighbours stay 0.3 spacings apart."""
TILE = 18
"""Edge of the periodic tile of Poisson-disk points in units of their least distance."""
ROUNDS = 40
"""Rounds of TILE^3 random darts each; after them hardly a gap is left."""


def regular(size: Array, spacing: float) -> Array:
    """Return points (n, 3) [m] of a lattice in a centred box of edges `size` [m] (3,), half a spacing inside.

    A whole number of cells fits along each edge, so the lattice spacing differs a little from `spacing` [m].
    """
    x, count = _lattice(size, spacing)
    return np.asarray((x / count - 0.5) * size)


def jittered(size: Array, spacing: float, rng: np.random.Generator) -> Array:
    """Return the points (n, 3) [m] of `regular`, each moved at random by up to JITTER / 2 of a spacing."""
    x, count = _lattice(size, spacing)
    x += JITTER * (rng.random(x.shape) - 0.5)
    return np.asarray((x / count - 0.5) * size)


def _lattice(size: Array, spacing: float) -> tuple[Array, Indices]:
    """Return the middles (n, 3) of unit cells, and how many (3,) lie along each edge."""
    count = np.maximum(1, np.rint(size / spacing)).astype(np.int64)
    x = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    return np.asarray(x), count


def poisson(size: Array, spacing: float, rng: np.random.Generator, seed: int) -> Array:
    """Return points (n, 3) [m] in a centred box of edges `size` [m] (3,), on average one in spacing^3.

    The points are cut out of endless copies of one periodic tile, turned and shifted at random, so that the
    least distance (about 0.85 `spacing`) holds everywhere.
    """
    tile = poisson_tile(seed)
    unit = spacing * (len(tile) / TILE**3) ** (1.0 / 3.0)
    edge = unit * TILE
    axes, shift = _random_rotation(rng), rng.random(3)
    middles = times((touching_tiles(size, edge, axes, shift) + 0.5 + shift) * edge, axes.T)
    near = np.all(np.abs(middles) <= 0.5 * size + 0.5 * np.sqrt(3.0) * edge, axis=1)
    base = times(tile * unit - 0.5 * edge, axes.T)
    parts = [p[np.all(np.abs(p) < 0.5 * size, axis=1)] for p in (base + m for m in middles[near])]
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def touching_tiles(size: Array, edge: float, axes: Array, shift: Array) -> Indices:
    """Return the indices (n, 3) of all tiles that touch a centred box of edges `size` [m], and of some near.

    Tile i holds the points p with floor(axes^T p / edge - shift) = i. The box is cut into cells no larger
    than a tile; a tile that a cell touches is at most one step from that of the cell's middle. So n
    grows with the box itself and not with the cube around it, however flat or thin the box is.
    """
    count = np.maximum(1, np.ceil(size / edge)).astype(np.int64)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1).reshape(-1, 3)
    home = np.floor(times(((cells + 0.5) / count - 0.5) * size, axes) / edge - shift).astype(np.int64)
    around = (home[:, None, :] + np.array(list(product((-1, 0, 1), repeat=3)))).reshape(-1, 3)
    around = around[np.lexsort((around[:, 2], around[:, 0], around[:, 1]))]
    is_new = np.any(np.diff(around, axis=0, prepend=around[:1] - 1) != 0, axis=1)
    return np.asarray(around[is_new])


@lru_cache(maxsize=4)
def poisson_tile(seed: int) -> Array:
    """Return points (n, 3) in a periodic cube of edge TILE, no two nearer than 1.

    Random sequential packing: darts are thrown, those too near an accepted point are dropped, and of the rest
    those that win over all their rivals of the same round are accepted. A grid with at most one point a cell
    finds the neighbours. n is about 0.6 TILE^3.

    Source: the goal and the grid of Bridson 2007; the rounds of darts and the periodic tile are ours.
    """
    rng = np.random.default_rng([seed, 0x7113])
    cells = int(np.ceil(TILE * np.sqrt(3.0)))
    offsets = _neighbours(cells)
    grid = np.full((cells**3, 3), np.inf)
    for _ in range(ROUNDS):
        home = rng.permutation(np.flatnonzero(np.isinf(grid[:, 0])))[: TILE**3]
        ijk = np.stack(np.unravel_index(home, (cells,) * 3), axis=-1)
        x = (ijk + rng.random(ijk.shape)) * (TILE / cells)
        alive = np.arange(len(home))
        for offset in offsets:
            alive = alive[_apart(x[alive], grid[_index(ijk[alive] + offset, cells)])]
        rivals, rank = np.full((cells**3, 3), np.inf), np.full(cells**3, -1)
        rivals[home[alive]], rank[home[alive]] = x[alive], np.arange(len(alive))
        winners = np.arange(len(alive))
        for offset in offsets[1:]:
            other = _index(ijk[alive[winners]] + offset, cells)
            winners = winners[(rank[other] < winners) | _apart(x[alive[winners]], rivals[other])]
        grid[home[alive[winners]]] = x[alive[winners]]
    return np.asarray(grid[np.isfinite(grid[:, 0])])


def _neighbours(cells: int) -> Indices:
    """Return the offsets (n, 3) of cells that may hold a point nearer than 1, the nearest first."""
    offsets = np.array(list(product(range(-2, 3), repeat=3)))
    gap = norms(np.maximum(np.abs(offsets) - 1, 0)) * (TILE / cells)
    order = np.argsort(norms(offsets), kind="stable")
    return np.asarray(offsets[order][gap[order] < 1.0])


def _index(ijk: Indices, cells: int) -> Indices:
    i, j, k = (ijk % cells).T
    return np.asarray((i * cells + j) * cells + k)


def _apart(a: Array, b: Array) -> NDArray[np.bool_]:
    """Return whether points are 1 or more apart in the periodic tile; a point at infinity is far from all."""
    d = np.abs(a - b)
    d = np.minimum(d, np.abs(TILE - d))
    return np.asarray(np.sum(d * d, axis=1) >= 1.0)


def _random_rotation(rng: np.random.Generator) -> Array:
    """Return a rotation matrix (3, 3), all directions equally likely: from a random unit quaternion."""
    w, x, y, z = (q := rng.standard_normal(4)) / math.hypot(*q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
