"""The law of the game's snow for one column at a time, as `web/drive/src/snow/law.ts` has it.

It is no physics: a type of snow supports a pressure p once it is packed to 1 / (1 - s (1 - exp(-p / p_k))),
and of what is pressed the share c stays. Both languages are held against one table of numbers,
`web/drive/tests/unit/sinkage.json`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SHORTEST_CONTACT = 0.14
"""The shortest contact of a tyre, which flattens on hard ground [m]."""
HALVINGS = 54
"""Steps of the bisection for the sinkage: to rounding, since searches take differences of it."""


class GameSnow(NamedTuple):
    """Hold the numbers of a type of snow in the game.

    strain: under boundless pressure, 0..1 [1]. pressure: that brings 63 % of it [Pa].
    compaction: share of what is pressed that is compacted, 0..1 [1]; the rest goes to the rims.
    """

    strain: float
    pressure: float
    compaction: float


def bearing_ratio(snow: GameSnow, pressure: ArrayLike) -> Array:
    """Return the density ratio at which snow bears a pressure [Pa]: 1 / (1 - s (1 - exp(-p / p_k)))."""
    p = np.maximum(np.asarray(pressure, float), 0.0)
    return np.asarray(1.0 / (1.0 + snow.strain * np.expm1(-p / snow.pressure)))


def bearing_depth(snow: GameSnow, depth: ArrayLike, pressure: ArrayLike) -> Array:
    """Return the depth of fresh snow of a `depth` [m] after it bore a pressure [Pa]: h r_k^(-1/c) [m]."""
    return np.asarray(np.asarray(depth, float) * bearing_ratio(snow, pressure) ** (-1.0 / snow.compaction))


def contact_area(radius: float, width: float, sinkage: ArrayLike) -> Array:
    """Return the contact area of a wheel that has sunk by z [m2]: width times the chord of the surface."""
    z = np.clip(np.asarray(sinkage, float), 0.0, radius)
    chord = 2.0 * np.sqrt(z * (2.0 * radius - z))
    return np.asarray(width * np.minimum(2.0 * radius, np.maximum(SHORTEST_CONTACT, chord)))


def wheel_sinkage(radius: float, width: float, load: ArrayLike, depth: ArrayLike, snow: GameSnow) -> Array:
    """Return how far a wheel sinks into fresh snow [m]: the z at which the snow below bears load / A(z).

    radius, width: of the wheel [m]. load: on it [N], depth: of the snow [m]; both of any shape that fits.
    """
    load, depth = np.broadcast_arrays(np.asarray(load, float), np.asarray(depth, float))
    low, high = np.zeros(load.shape), depth.copy()
    for _ in range(HALVINGS):
        z = 0.5 * (low + high)
        yields = depth - bearing_depth(snow, depth, load / contact_area(radius, width, z))
        low, high = np.where(yields > z, z, low), np.where(yields > z, high, z)
    return np.asarray(np.where(load > 0.0, 0.5 * (low + high), 0.0))
