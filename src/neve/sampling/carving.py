"""Leave out the snow that would start inside a solid."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.sampling import Samples
from neve.scene.errors import SceneError, SceneWarning

ROUNDING = 1e-3
"""Cells that a particle may lie inside a solid: snow that was laid on its surface, in single precision."""


def carved(
    samples: Samples,
    solids: Sequence[Solid],
    distance: Callable[[int, NDArray[np.float64]], NDArray[Any]],
    dx: float,
    name: str,
) -> Samples:
    """Return `samples` of the source `name` without those that start inside one of `solids`.

    distance(i, x): signed distance of points x (n, 3) from the surface of solid i, (n,) [m]; dx: cell [m]

    The others keep their volume, so that the source loses the mass of what is left out.

    Warns with SceneWarning how many, and in which solids. Errors: SceneError if no particle is left.
    """
    free = np.ones(len(samples.x), dtype=bool)
    found = []
    for i, solid in enumerate(solids):
        inside = free & (distance(i, samples.x) < -ROUNDING * dx)
        if count := int(np.count_nonzero(inside)):
            found.append((count, solid.name))
            free &= ~inside
    if not found:
        return samples
    if not free.any():
        raise SceneError(
            f"{name} starts wholly inside {_list([solid for _, solid in found])}: move one of them"
        )
    left_out = _list([f"{count} inside {solid}" for count, solid in found])
    warnings.warn(
        f"{name} starts with {left_out}, of {len(free)} particles: they are left out",
        SceneWarning,
        stacklevel=2,
    )
    return samples.only(free)


def _list(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
