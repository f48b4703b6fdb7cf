"""Flakes in the air: where they are, how they fall, and how they look while the shutter is open.

The path-traced film and the preview draw what `streaks` returns. The page of the viewer computes the same law
on the graphics card, from these constants.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import neve._render as _render
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.snow import unit

if TYPE_CHECKING:
    from neve.scene.schema.scene import Light

Floats = NDArray[np.float32]
Array = NDArray[np.float64]
Triple = tuple[float, float, float]

MOST = 250_000
"""Flakes of the cube of air that is repeated without end."""
AROUND = 1.6
"""Half the edge of the cube of air with flakes, in distances from the camera to its target."""
SWAY, PERIOD, SECOND = 0.04, 1.7, 0.7
"""How far flakes swing aside [m], how long a swing along x lasts [s], and swings along y over those along x:
on average, our choice."""
PACE, SPREAD = (0.75, 0.5), (0.5, 1.0)
"""Least speed and range of speeds over the average [1], least radius and range of radii [1]."""
SUNLIT, SKYLIT = 0.5, 0.35
"""Light of the sun and of the sky in a flake, of that of a white surface: our choice."""
FAINTEST = 0.03
"""Share of a pixel below which a flake is not drawn."""
LEAST = 0.6
"""Radius of the image of a flake that is drawn smaller than it is [px]: it is fainter instead."""
EDGE = 20
"""How far outside the picture flakes are looked at [px]."""
NEAREST = 0.3
"""Distance of a flake from the camera [m]: nearer ones are out of sight of any lens."""
HOME, HASTE, PHASE, RADIUS = 11, 14, 15, 16
"""Numbers of a flake's random numbers: of the first of three for its place, and of three others."""


@dataclass(frozen=True)
class FallingLaw:
    """Hold what the ways of flakes follow from.

    Attributes:
        count: flakes of a cube of air, which is repeated without end
        edge: of the cube [m]
        velocity: on average [m/s]
        radius: on average [m]
    """

    count: int
    edge: float
    velocity: Triple
    radius: float


def law_of(light: Light) -> FallingLaw | None:
    """Return how flakes fall; None: none do."""
    if not light.falling > 0.0:
        return None
    return FallingLaw(MOST, (MOST / light.falling) ** (1.0 / 3.0), light.flake_velocity, light.flake_radius)


def flakes_at(light: Light, lens: Lens, time: float, open_for: float = 0.0) -> tuple[Array, Array, Array]:
    """Return where the flakes around the camera are at `time` [s], and `open_for` [s] later; their radii.

    Places (n, 3) and (n, 3), radii (n,) [m].

    They are the same in the world wherever the camera is: of a cube of air that is repeated without end those
    count that are nearest to it, and no farther along any axis than `AROUND` times its target. Each falls
    with its own speed and swings aside.
    """
    law = law_of(light)
    if law is None:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    names = np.arange(law.count, dtype=np.uint32)
    home = np.stack([unit(names, HOME + k) for k in range(3)], axis=1).astype(np.float64) * law.edge
    pace = PACE[0] + PACE[1] * unit(names, HASTE).astype(np.float64)[:, None]
    velocity = np.array(law.velocity) * pace
    corner = lens.eye - 0.5 * law.edge
    first = corner + np.mod(home + velocity * time - corner, law.edge)
    near = np.flatnonzero(np.abs(first - lens.eye).max(axis=1) < AROUND * lens.distance)
    names, first, velocity, pace = names[near], first[near], velocity[near], pace[near, 0]
    last = first + velocity * open_for
    phase = 2.0 * math.pi * unit(names, PHASE).astype(np.float64)
    for place, t in ((first, time), (last, time + open_for)):
        turn = phase + 2.0 * math.pi * t / (PERIOD * pace)
        place[:, 0] += SWAY * np.sin(turn)
        place[:, 1] += SWAY * np.cos(SECOND * turn + phase)
    return first, last, law.radius * (SPREAD[0] + SPREAD[1] * unit(names, RADIUS).astype(np.float64))


def glow(sun: Triple, sky: Triple) -> Triple:
    """Return the light of a flake in sun and sky, each of what reaches a white surface."""
    red, green, blue = (SUNLIT * a + SKYLIT * b for a, b in zip(sun, sky, strict=True))
    return red, green, blue


def streaks(light: Light, lenses: tuple[Lens, Lens], time: float, open_for: float, color: Triple) -> Floats:
    """Return the ways of flakes in a picture while the shutter is open, (m, 10), the farthest first.

    lenses: of the moments when the shutter opens and shuts; time: of the middle [s]; color: light of a flake.
    Each row holds what `neve._render.veil` draws: a flake covers the pixels of its way, each for a share of
    the time.
    """
    before, after = lenses
    first, last, radius = flakes_at(light, before, time - 0.5 * open_for, open_for)
    a, b, z = before.project(first)
    c, d, far = after.project(last)
    size = radius * before.focal / np.maximum(z, NEAREST)
    inside = np.abs(2 * a - before.width) < before.width + 2 * EDGE
    inside &= np.abs(2 * b - before.height) < before.height + 2 * EDGE
    way = np.hypot(c - a, d - b)
    drawn = np.maximum(size, LEAST)
    cover = math.pi * size**2 / (math.pi * drawn**2 + 2.0 * drawn * way)
    rows = np.flatnonzero(inside & (z > NEAREST) & (far > NEAREST) & (cover > FAINTEST))
    rows = rows[np.argsort(-z[rows], kind="stable")]
    away = np.linalg.norm(first[rows] - before.eye, axis=1)
    columns: list[Any] = [a[rows], c[rows], b[rows], d[rows], drawn[rows], cover[rows], away]
    columns += [np.full(len(rows), value) for value in color]
    return np.stack(columns, axis=1).astype(np.float32)


def draw_falling(
    out: Floats, light: Light, lenses: tuple[Lens, Lens], time: float, open_for: float, depth: Floats | None
) -> Floats:
    """Return exposed light (h, w, 3) with flakes over it.

    depth (h, w): distance of what is seen [m], 0 for the sky; None: nothing hides a flake. Further arguments
    as of `streaks`.
    """
    sun, sky = (
        _scaled(color, min(strength, 1.0))
        for color, strength in ((light.sun_color, light.sun_strength), (light.sky_color, light.sky_strength))
    )
    shown = streaks(light, lenses, time, open_for, glow(sun, sky))
    far = np.zeros(out.shape[:2], np.float32) if depth is None else depth
    picture, near = (np.ascontiguousarray(a, np.float32) for a in (out, far))
    return _render.veil(picture, near, shown)


def _scaled(color: Triple, factor: float) -> Triple:
    return color[0] * factor, color[1] * factor, color[2] * factor
