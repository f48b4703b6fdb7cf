"""Lay snow on the ground: lift each particle by the height of the ground below it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from neve.sampling import Samples
from neve.scene.errors import SceneError

Array = NDArray[np.float64]
Surface = Callable[[Array], tuple[Array, Array]]
"""Points [m] (n, 3) -> signed distances [m] (n,) and unit normals (n, 3) of a ground."""

STEEPEST = 0.05
"""Upward part of a normal below which ground is a wall, on which nothing lies."""
ROUNDS = 50
"""Of Newton's iteration; one is enough for planes and upright height maps."""
NEAR = 2e-6
"""Distance from the ground that is none, in metres or as a share of coordinates: solids are float32."""


Lift = Callable[[Array], Array]
"""Points [m] (n, 3) -> height of the ground at their x and y [m] (n,)."""


def height_over(grounds: Sequence[Surface], name: str) -> Lift:
    """Return what tells the height of the highest of `grounds` [m]; `name`: of the source, in messages.

    It raises SceneError for ground that is too steep to lie on.
    """
    return lambda x: np.asarray(np.max([_heights(x, ground, name) for ground in grounds], axis=0))


def draped(samples: Samples, lift: Lift) -> Samples:
    """Return `samples` with z + h(x, y) in place of z, where h is what `lift` returns [m].

    The map (x, y, z) -> (x, y, z + h) keeps volumes, so density and mass stay, and the depth of the snow
    measured upright.
    """
    lifted = samples.x.copy()
    lifted[:, 2] += lift(samples.x)
    return replace(samples, x=lifted)


def _heights(x: Array, ground: Surface, name: str) -> Array:
    """Return the height [m] of the ground at the x and y of points (n, 3), by Newton's iteration, (n,)."""
    at = x.copy()
    for _ in range(ROUNDS):
        phi, normal = ground(np.ascontiguousarray(at))
        up = np.asarray(normal, np.float64)[:, 2]
        if up.min() < STEEPEST:
            k = int(up.argmin())
            raise SceneError(
                f'{name}.on = "terrain" finds a wall at ({at[k, 0]:.3g}, {at[k, 1]:.3g}) m, on which no snow '
                "lies: choose another place, or turn the collider"
            )
        step = np.asarray(phi, np.float64) / up
        at[:, 2] -= step
        if np.abs(step).max() <= NEAR * max(1.0, float(np.abs(at).max())):
            return np.asarray(at[:, 2])
    raise SceneError(f'{name}.on = "terrain" finds no single height of the ground: turn the collider less')
