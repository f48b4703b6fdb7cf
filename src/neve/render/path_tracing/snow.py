"""Snow as geometry: a surface as fine as its grains, and flakes that stand on it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.sampling.noise import DEVIATION, fractal
from neve.surface.carry import STILL, Carry
from neve.surface.grains import Grains, grains_of
from neve.surface.mesh import LEVEL, SurfaceMesh, mesh_of, snow_field

Floats = NDArray[np.float32]

LUMPS = 0.40
"""Strength of lumps: a particle weighs exp(LUMPS n), n noise of deviation 1 at its first place."""
LUMP_SIZES = (14.0, 6.3, 2.8, 1.3)
"""Sizes of lumps in particle spacings, all as strong: with one size alone snow looks like polystyrene."""
SOAKED = 0.35
"""Liquid share of a particle from which a film of water hides its flakes."""
LOOSE, FIRM = 0.60, 0.88
"""Share of packed snow at a grain, from which its flake begins to shrink, and at which it is gone."""

_TETRAHEDRON = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], np.float32) / np.sqrt(
    np.float32(3)
)
_SIDES = np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
_TURNS = 256
_PRIMES = (0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F, 0x165667B1)


@dataclass(frozen=True)
class Flakes:
    """Hold flakes.

    centres (n, 3) and radii (n,) [m]; names (n,): a number each keeps for the whole run; turns: rotation of
    their snow since the first frame, (n, 3, 3) or (1, 3, 3)
    """

    centres: Floats
    radii: Floats
    names: NDArray[np.uint32]
    turns: Floats = field(default_factory=lambda: STILL.turn)

    def triangles(self) -> tuple[Floats, NDArray[np.uint32]]:
        """Return vertices (4 n, 3) and faces (4 n, 3): a tetrahedron each, turned at random by its number,
        and with its snow."""
        turned = _turned()[self.names % np.uint32(_TURNS)] @ self.turns.transpose(0, 2, 1)
        vertices = self.centres[:, None] + self.radii[:, None, None] * turned
        faces = (4 * np.arange(len(self.centres)))[:, None, None] + _SIDES
        return vertices.reshape(-1, 3), faces.reshape(-1, 3).astype(np.uint32)


@dataclass(frozen=True)
class SnowGeometry:
    """Hold the surface and the flakes of a frame; size: of a grain [m].

    wet (n,): how wet the snow is at each vertex of the surface, 0 dry, 1 water; None: all dry. drops (m, 3):
    places of water that flies [m]; pool: surface of water that stands together
    """

    surface: SurfaceMesh
    flakes: Flakes
    size: float
    wet: Floats | None = None
    drops: Floats | None = None
    pool: SurfaceMesh | None = None


NOTHING = SnowGeometry(
    SurfaceMesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32)),
    Flakes(np.zeros((0, 3), np.float32), np.zeros(0, np.float32), np.zeros(0, np.uint32)),
    0.0,
)
"""No snow at all."""


def lumps(x: NDArray[Any], spacing: float) -> Floats:
    """Return the weight of each particle, about 1, from its place `x` (n, 3) [m] in the first frame."""
    at = np.asarray(x, np.float64)
    n = sum(fractal(at, size * spacing, 1, 7 + k) for k, size in enumerate(LUMP_SIZES))
    return np.asarray(np.exp(LUMPS / len(LUMP_SIZES) ** 0.5 / DEVIATION * n), np.float32)


def grain_count(spacing: float, pixel: float, particles: int, most: int, across: float) -> int:
    """Return how many grains a particle is drawn as: one is then `across` pixels large at the target.

    most: grains in all that may be drawn. At least 1 and at most 125 for each particle.
    """
    wanted = (spacing / max(across * pixel, 1e-9)) ** 3
    return int(max(1.0, min(wanted, 125.0, most / max(particles, 1))))


def flake_share(most: int, grains: int) -> float:
    """Return the share of flakes of which about `most` are drawn, if half of the `grains` lie at the surface.

    It is that of a whole run: a share that followed each frame would take flakes away as snow flows in.
    """
    return min(1.0, most / max(0.5 * grains, 1.0))


def snow_geometry(
    x: NDArray[Any],
    id: NDArray[Any],
    weights: NDArray[Any] | None,
    spacing: float,
    count: int,
    flakes: float,
    flake_size: float,
    carry: Carry = STILL,
    water: NDArray[Any] | None = None,
) -> SnowGeometry:
    """Return the surface and the flakes of a frame.

    x (n, 3) [m], finite; id (n,); weights (n,): see `lumps`; spacing [m]; count: grains of a particle;
    flakes: share of those at the surface that are drawn, see `flake_share`; flake_size: their mean radius
    in grain sizes; carry: how the snow of the particles has moved; water (n,): their liquid shares. Wet snow
    has no flakes.
    """
    grains = grains_of(x, id, spacing, count, carry)
    firm = snow_field(grains, weights)
    surface = mesh_of(firm, LEVEL)
    chosen = _flakes(grains, id, firm, flakes, flake_size, water)
    return SnowGeometry(surface, chosen, grains.size)


def _flakes(
    grains: Grains, id: NDArray[Any], within: Any, share: float, size: float, water: NDArray[Any] | None
) -> Flakes:
    """Choose the flakes: grains at the surface, those whose random number is below a share that is the same
    in all frames."""
    first = np.asarray(id, np.uint64)[:, None] * np.uint64(512)
    each = np.asarray(first + np.arange(grains.count, dtype=np.uint64), np.uint64).ravel()
    names = hashed(each.astype(np.uint32) ^ (each >> np.uint64(32)).astype(np.uint32))
    chosen = np.flatnonzero(names < np.uint32(share * (2**32 - 1)))
    here = grains.x[chosen]
    firm = within.sample(here)
    t = np.clip((FIRM - firm) / (FIRM - LOOSE), 0.0, 1.0)
    if water is not None:
        t *= np.clip(1.0 - np.asarray(water, np.float32)[chosen // grains.count] / SOAKED, 0.0, 1.0) ** 2
    chosen, here, t = (a[t > 0.0] for a in (chosen, here, t))
    kept = names[chosen]
    turns = grains.carry.turn
    if len(turns) > 1:
        turns = turns[chosen // grains.count]
    jitter = np.stack([unit(kept, k) - 0.5 for k in range(3)], axis=1) * (0.8 * grains.size)
    jitter = (turns @ jitter[:, :, None])[:, :, 0]
    # A sum of uniform numbers stands for a normal one: radii spread by a factor of about 1.5.
    normal = (unit(kept, 3) + unit(kept, 4) + unit(kept, 5) - 1.5) * 2.0
    radii = size * grains.size * np.exp(0.45 * normal) * np.sqrt(t)
    return Flakes((here + jitter).astype(np.float32), radii.astype(np.float32), kept, turns)


def hashed(a: NDArray[np.uint32], k: int = 0) -> NDArray[np.uint32]:
    """Return random bits of whole numbers; k chooses another set."""
    with np.errstate(over="ignore"):
        a = a + np.uint32((k * _PRIMES[0]) % 2**32)
        a = (a ^ (a >> np.uint32(16))) * np.uint32(0x7FEB352D)
        a = (a ^ (a >> np.uint32(15))) * np.uint32(0x846CA68B)
        return a ^ (a >> np.uint32(16))


def unit(names: NDArray[np.uint32], k: int) -> Floats:
    """Return a random number in [0, 1) of each name, another for each k."""
    return np.asarray((hashed(names, k + 1) >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24))


def _turned() -> Floats:
    """Return the tetrahedron in `_TURNS` random orientations, (turns, 4, 3)."""
    rng = np.random.default_rng(20)
    q = rng.normal(size=(_TURNS, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    turns = np.array(rows, np.float32).transpose(2, 0, 1)
    return np.asarray(np.einsum("tij,vj->tvi", turns, _TETRAHEDRON), np.float32)
