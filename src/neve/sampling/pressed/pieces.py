"""Divide snow by curved sheets, one after another, into pieces whose sizes are planned.

A sheet ends where it meets those before it, as cracks do that divide a body piece by piece (Bohn, Pauchard
and Couder 2005, from memory). So each piece has faces, edges and corners, no sheet ends within a piece, and
their sizes are those of the plan whatever the seed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import norms, product
from neve.sampling.regions import Region

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CURVATURE = (1.0, 10.0)
"""Radius of the sphere that a sheet lies on, in radii of what it divides."""
NORMALS = 6
"""Random directions of which a sheet takes the one along which its part is longest: pieces are no needles."""
POINTS = 300
"""Random points for each piece, on which volumes are measured: a share s is met within sqrt(s / points)."""
ROUNDS = 64
"""Most times that as many points are thrown into the box as are wanted in the region."""


class Sheet(NamedTuple):
    """Hold a part of a sphere that divides a part of the snow.

    centre: of the sphere [m], (3,). radius [m]. within, beyond: the sheet that divides what is inside and
    outside of the sphere, None where that is a piece
    """

    centre: Array
    radius: float
    within: Sheet | None
    beyond: Sheet | None


def divide(space: Region, shares: Array, seed: int) -> Sheet | None:
    """Return the first of the sheets that divide a region into pieces.

    Args:
        space: the region
        shares: of its volume, one for each piece, in any order [1] (k,)
        seed: any whole number

    Returns: the sheet that divides all of it; None for one piece, or a region too thin to hit with points.
    """
    rng = np.random.default_rng([seed % 2**64, 0x5EE7])
    return _divided(np.sort(shares), scattered(space, POINTS * len(shares), rng), rng)


def locate(x: Array, first: Sheet | None) -> tuple[Array, NDArray[np.int64]]:
    """Return how far points are from the sheets around their piece, and which piece they are in.

    Args:
        x: points [m], (n, 3), from the middle of the region's box
        first: what `divide` returns

    Returns: distance to the nearest of the spheres that bound the point's piece [m] (n,), infinite if there
    is none; number of the piece, from 0 on (n,). Neither depends on the other points.
    """
    gap, piece = np.full(len(x), np.inf), np.zeros(len(x), np.int64)
    waiting: list[tuple[Sheet | None, NDArray[np.int64]]] = [(first, np.arange(len(x)))]
    pieces = 0
    while waiting:
        sheet, rows = waiting.pop()
        if sheet is None:
            piece[rows] = pieces
            pieces += 1
            continue
        beyond = norms(x[rows] - sheet.centre) - sheet.radius
        gap[rows] = np.minimum(gap[rows], np.abs(beyond))
        waiting += [(sheet.within, rows[beyond < 0]), (sheet.beyond, rows[beyond >= 0])]
    return gap, piece


def scattered(space: Region, count: int, rng: np.random.Generator) -> Array:
    """Return `count` random points of a region [m] (count, 3), fewer if it fills hardly any of its box."""
    found, left = [np.zeros((0, 3))], count
    for _ in range(ROUNDS):
        x = (rng.random((count, 3)) - 0.5) * space.size
        x = x[space.inside(x)][:left]
        found.append(x)
        left -= len(x)
        if not left:
            break
    return np.concatenate(found)


def _divided(part: Array, x: Array, rng: np.random.Generator) -> Sheet | None:
    """Return the sheets that divide a part, given by points `x` [m] (n, 3), by its sorted shares (k,)."""
    if len(part) < 2 or len(x) < 2:
        return None
    some, others = _dealt(part, rng)
    centre, radius, within = _between(x, float(some.sum() / part.sum()), rng)
    return Sheet(centre, radius, _divided(some, x[within], rng), _divided(others, x[~within], rng))


def _dealt(part: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Deal sorted shares (k,) to two hands, one of each pair of neighbours at random to each.

    So both sides of a sheet have pieces of all sizes, and what an impact crushes is a fair sample of them.
    """
    odd = len(part) % 2
    first = np.zeros(len(part), np.bool_)
    first[odd + 2 * np.arange(len(part) // 2) + rng.integers(0, 2, len(part) // 2)] = True
    first[0] |= bool(odd and part[first].sum() < part[~first].sum())
    return part[first], part[~first]


def _between(x: Array, share: float, rng: np.random.Generator) -> tuple[Array, float, Mask]:
    """Return centre and radius of a sphere [m] with a share of points `x` (n, 3) within, and which are."""
    away = x - x.mean(axis=0)
    normals = rng.standard_normal((NORMALS, 3))
    normals /= norms(normals)[:, None]
    normal = normals[int(np.argmax(product(away, normals.T).std(axis=0)))]
    around = float(np.sqrt(5.0 / 3.0 * np.mean(np.sum(away * away, axis=1))))  # of a ball with this gyration
    radius = around * float(CURVATURE[0] * (CURVATURE[1] / CURVATURE[0]) ** rng.random())
    centre = x.mean(axis=0) + radius * normal
    distance = norms(x - centre)
    count = min(max(round(share * len(x)), 1), len(x) - 1)
    low, high = np.partition(distance, [count - 1, count])[count - 1 : count + 1]
    cut = float(0.5 * (low + high))
    return centre, cut, distance < cut
