"""Drops of water that fly, drawn over a finished picture: in it they would cast shadows as of stones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.render.path_tracing.daylight import sky_toward
from neve.render.path_tracing.snow import hashed, unit

if TYPE_CHECKING:
    from neve.render.path_tracing.lens import Lens
    from neve.scene.schema.scene import Light

Floats = NDArray[np.float32]

RADIUS = 0.46
"""Radius of a ball that holds the water of a particle of snow of 400 kg/m3, in particle spacings."""
LEAST = 0.55
"""Radius of the image of a drop that is drawn smaller than it is [px]: it is fainter instead."""
MOST = 40
"""Radius of the image of a drop at most [px]."""
GLINT = 1.2
"""Light of the sun in a drop: our choice."""


def draw_drops(
    out: Floats,
    centres: NDArray[Any],
    spacing: float,
    depth: Floats | None,
    lens: Lens,
    light: Light,
    exposed: NDArray[Any],
) -> None:
    """Draw clear drops into exposed light `out` (h, w, 3), in place, the farthest first.

    centres (n, 3) [m]; spacing of particles [m]; depth (h, w): distance of what is seen [m], 0 for the sky;
    exposed (3,): factors of exposure. A drop lets what is behind it through and mirrors the sky, by Fresnel's
    law as approximated by Schlick 1994, and the sun.
    """
    column, row, z = lens.project(centres)
    names = hashed(np.arange(len(centres), dtype=np.uint32))
    radius = RADIUS * spacing * (0.6 + 0.5 * unit(names, 1)) * lens.focal / np.maximum(z, 1e-9)
    far = np.linalg.norm(np.asarray(centres, np.float64) - lens.eye, axis=1)
    fade = np.minimum(radius / LEAST, 1.0) ** 2
    radius = np.clip(radius, LEAST, MOST)
    right, up, forward = lens.axes
    half = np.asarray(light.towards_sun) - forward
    half /= max(float(np.linalg.norm(half)), 1e-9)
    for k in np.argsort(-far):
        if not z[k] > 1e-3 * lens.distance:
            continue
        reach = radius[k] + 1.0
        low, high = max(int(row[k] - reach), 0), min(int(row[k] + reach) + 1, lens.height)
        first, last = max(int(column[k] - reach), 0), min(int(column[k] + reach) + 1, lens.width)
        if low >= high or first >= last:
            continue
        b, a = np.mgrid[low:high, first:last] + 0.5
        a, b = (a - column[k]) / radius[k], (row[k] - b) / radius[k]
        r = np.hypot(a, b)
        share = fade[k] * np.clip((1.0 - r) * radius[k] + 0.5, 0.0, 1.0)
        if depth is not None:
            behind = depth[low:high, first:last]
            share = np.where((behind > 0) & (behind < far[k]), 0.0, share)
        front = np.sqrt(np.maximum(1.0 - r * r, 0.0))
        normal = a[..., None] * right + b[..., None] * up - front[..., None] * forward
        mirror = 0.02 + 0.98 * (1.0 - front) ** 5
        toward = forward + 2.0 * front[..., None] * normal
        sky = sky_toward(light, toward.reshape(-1, 3)).reshape(toward.shape) * exposed
        glint = GLINT * np.clip(normal @ half, 0.0, 1.0) ** 60
        seen = out[low:high, first:last]
        clear = seen * (1.0 - mirror[..., None]) + sky * mirror[..., None] + glint[..., None]
        seen += (share[..., None] * (clear - seen)).astype(np.float32)
