"""Leave out the snow that would start inside a solid."""

from __future__ import annotations

import warnings

import numpy as np

from neve.model import Model
from neve.sampling import Samples
from neve.scene.errors import SceneError, SceneWarning

ROUNDING = 1e-3
"""Cells that a particle may lie inside a solid: snow that was laid on its surface, in single precision."""


def carved(samples: Samples, model: Model, name: str) -> Samples:
    """Return `samples` of the source `name` without those that start inside a solid of `model`.

    The others keep their volume, so that the source loses the mass of what is left out.

    Warns with SceneWarning how many, and in which solids. Errors: SceneError if no particle is left.
    """
    free = np.ones(len(samples.x), dtype=bool)
    found = []
    for i, solid in enumerate(model.solids):
        phi, _ = model.native.surface(i, np.ascontiguousarray(samples.x))
        inside = free & (phi < -ROUNDING * model.numerics.dx)
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
