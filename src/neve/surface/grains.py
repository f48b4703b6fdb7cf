"""Draw each particle as many grains, which go with it: what is seen is not the grid of the simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _surface
from neve._surface import Field
from neve.surface.carry import STILL, Carry
from neve.surface.volume import amounts, points

Floats = NDArray[np.float32]

ALONE, AMONG = 0.10, 0.35
"""Share of its room that other snow fills: a particle is alone below the first, not above the second."""

OWN = (115 / 192) ** 3
"""What a particle finds of itself in its field, on average over places [1]: the integral of the quadratic
B-spline times the hat function of the interpolation is 115/192 along each axis."""


@dataclass(frozen=True)
class Grains:
    """Hold the grains of the particles of a frame.

    x (n k, 3): positions [m], the k grains of a particle one after the other. count: k. size: edge of the
    cube that a grain takes [m], s / k^(1/3). lone (n,): 0 for a particle among others, 1 for a lone one.
    carry: how the snow of the particles has moved
    """

    x: Floats
    count: int
    size: float
    lone: Floats
    carry: Carry = STILL

    @property
    def particle(self) -> NDArray[np.int64]:
        """Row of the particle of each grain, (n k,)."""
        return np.arange(len(self.x)) // self.count


def grains_of(x: NDArray[Any], id: NDArray[Any], spacing: float, count: int, carry: Carry = STILL) -> Grains:
    """Return `count` grains of each particle.

    Among others the grains of a particle fill its cell evenly, jittered. Those of a lone particle gather in
    crumbs, each half of the one before, so that debris is no cloud of equal balls. Where a grain lies beside
    its particle depends on the particle's id, its surroundings and `carry` alone: nothing crawls from frame
    to frame, and what turns or shears takes its grains along.

    x: positions (n, 3) [m]; id (n,); spacing s: of particles at rest [m]; count: 1 to 512.
    """
    places = points(x)
    lone = loneliness(places, spacing)
    names = np.ascontiguousarray(id).astype(np.int64, copy=False)
    found = _surface.grains(places, names, lone, carry.offset, spacing, count)
    return Grains(found, count, spacing / count ** (1.0 / 3.0), lone, carry)


def loneliness(x: NDArray[Any], spacing: float) -> Floats:
    """Return how alone each particle is: 0 within snow, 1 with hardly any other around.

    It follows the volume fraction of the other particles on a grid of cells 2 s wide, smoothly, so that a
    particle that flies away comes apart into crumbs little by little.
    """
    places = points(x)
    cell = 2.0 * spacing
    share = np.float32((spacing / cell) ** 3)
    fraction = Field(places, amounts(1.0) * share, cell).sample(places)
    t = np.clip((AMONG - (fraction - OWN * share)) / (AMONG - ALONE), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float32)
