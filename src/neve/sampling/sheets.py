"""Make curved weak sheets of random extent, along which snow breaks into pieces of all sizes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from neve.reproducible import norms
from neve.sampling.noise import across

Array = NDArray[np.float64]

CURVATURE = (1.0, 10.0)
"""Radii of the spheres that sheets are cut from, in radii of the ball around the box."""

LEAST_EXTENT = 0.5
"""Radius of the smallest sheet, in mean distances between sheets; the largest has that of the ball around
the box."""

MOST_SHEETS = 20_000
"""Sheets of one octave; beyond, there are fewer than were asked for."""


class Sheet(NamedTuple):
    """Hold a part of a sphere: what of it lies within `extent` of `place`.

    place: a point of it [m], (3,). centre: of the sphere [m], (3,). radius: of the sphere [m]. extent [m]
    """

    place: Array
    centre: Array
    radius: float
    extent: float


def sheets(x: Array, size: Array, feature_size: float, width: float, octaves: int, seed: int) -> Array:
    """Return at points `x` the noise of snow with weak sheets: 0 beside them, -1 in their middle.

    A sheet is a piece of a random sphere of 1 to 10 times the radius of the snow, cut off at a random
    distance from a random point of it; `neve.sampling.noise.across` is its profile, and where sheets cross,
    the deepest counts. There are so many that a straight line meets one every `feature_size` on average.
    Octave o has sheets 2^-o as far apart, as wide and as deep.
    The value at a point does not depend on the other points.

    Args:
        x: points [m], (n, 3), in a centred box of edges `size` [m] (3,)
        feature_size: mean distance between sheets along a line [m]
        width: of a sheet [m]
        octaves: number of octaves [1]
        seed: any whole number

    Returns: (n,) [1]

    Source: sheets cut from spheres by spheres, which weaken snow, are part of a recipe for snowballs in
    public code of the first author of Stomakhin et al. 2013; their number, extent and profile are ours.
    (There each of 500 halves the stiffness, and what overlaps adds up.)
    """
    from scipy.spatial import cKDTree

    total = np.zeros(len(x))
    tree = cKDTree(x)
    for octave in range(octaves):
        share = 0.5**octave
        rng = np.random.default_rng([seed % 2**64, octave, 0x5EE7])
        for sheet in _drawn(rng, size, feature_size * share):
            near = np.asarray(tree.query_ball_point(sheet.place, sheet.extent, return_sorted=True), np.int64)
            distance = np.abs(norms(x[near] - sheet.centre) - sheet.radius)
            total[near] = np.minimum(total[near], share * across(distance, width * share))
    return total


def _drawn(rng: np.random.Generator, size: Array, apart: float) -> Iterator[Sheet]:
    """Yield sheets through the box until their area in it is 2 volume / apart.

    A line crosses half of the area in a unit of volume per unit of length (isotropic surfaces). What a sheet
    has inside the box is measured by the share of 64 random points of its disc that are.
    """
    around = 0.5 * float(norms(size))
    left = 2.0 * float(np.prod(size)) / apart
    for _ in range(MOST_SHEETS):
        place, normal = (rng.random(3) - 0.5) * size, rng.standard_normal(3)
        normal /= norms(normal)
        radius = around * float(CURVATURE[0] * (CURVATURE[1] / CURVATURE[0]) ** rng.random())
        least = min(LEAST_EXTENT * apart, around)
        extent = float(least * (around / least) ** rng.random())
        yield Sheet(place, place + radius * normal, radius, extent)
        across = rng.standard_normal((64, 3))
        across -= np.sum(across * normal, axis=1)[:, None] * normal
        across *= (extent * np.sqrt(rng.random(64)) / norms(across))[:, None]
        inside = np.mean(np.all(np.abs(place + across) <= 0.5 * size, axis=1))
        left -= float(np.pi * extent**2 * inside)
        if left <= 0:
            return
