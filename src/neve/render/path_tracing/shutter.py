"""Motion blur: a frame as the mean of several exposures while the shutter is open."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve._surface import Field
from neve.render.path_tracing.tracer import Layers
from neve.surface.volume import amounts, points

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.geometry.pose import Pose
    from neve.render.path_tracing.lens import Lens
    from neve.render.path_tracing.snow import Flakes, SnowGeometry

Floats = NDArray[np.float32]
Placed = Sequence[tuple["Solid", "Pose"]]
Moment = tuple[Placed, "Lens"]
"""Where the solids are, and what is looked through."""
Instant = Callable[[float], Moment]
"""Tell the moment that is so long after the frame [s], or before it."""

STEP = 2.0
"""Pixels that an image moves between two exposures, if there are paths enough."""
LEAST = 0.5
"""Pixels below which a smear is none."""
SEEN = 20_000
"""Particles whose smear is looked at."""


def smear(before: Lens, after: Lens, x0: NDArray[Any], x1: NDArray[Any]) -> NDArray[np.float64]:
    """Return how far images move (n,) [px] of points that go from x0 to x1 (n, 3) [m]; 0 out of sight."""
    q0, r0, near = before.project(x0)
    q1, r1, far = after.project(x1)
    moved = np.hypot(q1 - q0, r1 - r0)
    sight = (near > 1e-6) & (far > 1e-6)
    for q, r in ((q0, r0), (q1, r1)):
        sight &= (np.abs(2 * q - before.width) < 2 * before.width) & (
            np.abs(2 * r - before.height) < 2 * before.height
        )
    return np.where(sight, moved, 0.0)


def exposures(x: NDArray[Any], v: NDArray[Any], at: Instant, open_for: float, most: int) -> list[float]:
    """Return the times [s] around the frame at which it is exposed: the middles of equal parts of `open_for`.

    So many that an image moves `STEP` px from one to the next, if that is not more than `most`; those of
    snow at x (n, 3) [m] that moves with v (n, 3) [m/s], of what rests, and of the corners of solids count.
    """
    half = 0.5 * open_for
    chosen = slice(None, None, max(1, len(x) // SEEN))
    here, step = np.asarray(x[chosen], np.float64), half * np.asarray(v[chosen], np.float64)
    (first, before), (last, after) = at(-half), at(half)
    moved = [smear(before, after, here - step, here + step), smear(before, after, here, here)]
    for (solid, pose), (_, then) in zip(first, last, strict=True):
        if solid.visible and not solid.endless and solid.motion != "static":
            corners = solid.reach / math.sqrt(3.0) * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0)
            places = [corners @ p.rotation.T + p.position for p in (pose, then)]
            moved.append(smear(before, after, *places))
    # A few specks that fly past decide nothing.
    longest = max((float(np.percentile(m, 99.5)) for m in moved if len(m)), default=0.0)
    count = 1 if longest < LEAST else max(1, min(most, math.ceil(longest / STEP)))
    return [open_for * ((k + 0.5) / count - 0.5) for k in range(count)]


def velocities(places: NDArray[Any], x: NDArray[Any], v: NDArray[Any], spacing: float) -> Floats:
    """Return velocities (m, 3) [m/s] at places (m, 3): sum_p w_p v_p / sum_p w_p, w the blurred B-spline.

    x (n, 3) [m], v (n, 3) [m/s]: of the particles; spacing of these at rest [m], as large as a cell.
    """
    here, where = points(places), points(x)
    if not len(here) or not len(where):
        return np.zeros((len(here), 3), np.float32)
    total = Field(where, amounts(1.0), spacing, 1).sample(here)
    parts = [Field(where, amounts(v[:, k]), spacing, 1).sample(here) for k in range(3)]
    return np.asarray(np.stack(parts, axis=1) / np.maximum(total, 1e-6)[:, None], np.float32)


class Motion:
    """Move the snow of a frame, surface and flakes, each vertex at the velocity there, and water."""

    def __init__(self, snow: SnowGeometry, x: NDArray[Any], v: NDArray[Any], spacing: float) -> None:
        """Prepare. x (n, 3) [m], v (n, 3) [m/s]: of the particles; spacing of these at rest [m]."""
        self._snow = snow
        self._surface = velocities(snow.surface.vertices, x, v, spacing)
        self._flakes = velocities(snow.flakes.centres, x, v, spacing)

    def after(self, dt: float) -> SnowGeometry:
        """Return the snow as it is `dt` [s] later."""
        surface, flakes, pool = self._snow.surface, self._snow.flakes, self._snow.pool
        step = np.float32(dt)
        if pool is not None and pool.velocity is not None:
            pool = replace(pool, vertices=pool.vertices + step * pool.velocity)
        return replace(
            self._snow,
            surface=replace(surface, vertices=surface.vertices + step * self._surface),
            flakes=replace(flakes, centres=flakes.centres + step * self._flakes),
            pool=pool,
        )

    def sharp(self, before: Lens, after: Lens, open_for: float) -> Flakes:
        """Return the flakes whose image does not move while the shutter is open."""
        flakes, half = self._snow.flakes, 0.5 * open_for * self._flakes
        chosen = smear(before, after, flakes.centres - half, flakes.centres + half) < 2 * LEAST
        turns = flakes.turns[chosen] if len(flakes.turns) > 1 else flakes.turns
        return replace(
            flakes,
            centres=flakes.centres[chosen],
            radii=flakes.radii[chosen],
            names=flakes.names[chosen],
            turns=turns,
        )


def mean(exposed: Iterator[Layers]) -> Layers:
    """Return the mean of several layers; the flakes and drops of the first."""
    total, count = next(exposed), 1
    names = [field.name for field in fields(Layers) if field.name not in ("flakes", "drops")]
    for layers in exposed:
        count += 1
        for name in names:
            if (part := getattr(layers, name)) is not None:
                setattr(total, name, getattr(total, name) + part)
    for name in names:
        if (part := getattr(total, name)) is not None:
            setattr(total, name, part / np.float32(count))
    return total
