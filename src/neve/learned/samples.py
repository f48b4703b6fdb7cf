"""Samples of a return map, from which a network learns, and what it is told besides strains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Constants = dict[str, float]

STIFFNESS = 1e5
"""E0 of the samples [Pa]; their stresses are in units of it."""


@dataclass(frozen=True)
class Samples:
    """Hold strains u, expansion points u0 (n, 3), contexts y (n, Y), and stresses at both (n, 3)."""

    u: Array
    u0: Array
    y: Array
    T: Array
    T0: Array


def context(u0: Array, told: Array) -> Array:
    """Return y (n, Y): two bounded functions each of sorted strains u0 (n, 3), and what the snow tells."""
    size = np.abs(u0)
    return np.concatenate([u0 / (1 + size), u0 / (6 + size), told], axis=1)


def diagonal(strain: Array) -> Array:
    """Return F (n, 3, 3) of logarithmic strains (n, 3)."""
    F = np.zeros((len(strain), 3, 3))
    F[:, range(3), range(3)] = np.exp(strain)
    return F


def joined(parts: list[Samples]) -> Samples:
    """Return all samples in one."""
    names = Samples.__dataclass_fields__
    return Samples(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
