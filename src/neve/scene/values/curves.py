"""Keyframes: values at some times, and smooth curves through them at all others."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def keyed(part: Any, name: str, t: float) -> Array:
    """Return what `name` of a part of a scene is at time `t` [s], (m,), as its `keyframes` have it.

    A keyframe that leaves it out has the part's own. The curves are those of `monotone`.
    """
    own, keys = getattr(part, name), part.keyframes
    values = [own if getattr(key, name) is None else getattr(key, name) for key in keys] or [own]
    table = np.array(values, np.float64).reshape(len(values), -1)
    return monotone([key.t for key in keys] or [0.0], table, t)


def monotone(times: Sequence[float], values: Array, t: float) -> Array:
    """Return values (n, m) at increasing times (n,) as they are at time `t`: (m,).

    Cubic Hermite curves, whose slope at a time within is the weighted harmonic mean of the slopes of both
    chords, and 0 where these differ in sign and at both ends (Fritsch and Butland 1984): through all values,
    smooth in velocity, without overshoot; constant outside.
    """
    k = bisect_right(times, t) - 1
    if k < 0 or k == len(times) - 1:
        return np.asarray(values[max(k, 0)])
    h = np.diff(np.asarray(times, np.float64))
    chords = np.diff(values, axis=0) / h[:, None]

    def slope(i: int) -> Array:
        if i in (0, len(times) - 1):
            return np.zeros(values.shape[1])
        a, b = chords[i - 1], chords[i]
        same = a * b > 0.0
        first, second = 2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]
        ratio = first / np.where(same, a, 1.0) + second / np.where(same, b, 1.0)
        return np.where(same, (first + second) / np.where(same, ratio, 1.0), 0.0)

    s = (t - times[k]) / h[k]
    rise = s * s * (3.0 - 2.0 * s)
    start, end = s * (1.0 - s) ** 2, s * s * (s - 1.0)
    between = (1.0 - rise) * values[k] + rise * values[k + 1]
    return np.asarray(between + h[k] * (start * slope(k) + end * slope(k + 1)))
