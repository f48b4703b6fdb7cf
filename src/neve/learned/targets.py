"""What a network learns: the return map of a law at a given hardening, in units that serve any stiffness.

The unit of strain s is that at which snow yields, so that flow begins at strains of about 1; that of stress
is E s, E the stiffness as hardened. The hardening is that at the expansion point and stays in the energy, as
in Li et al. 2022; with it the units change from one expansion to the next, and the network serves every one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve import _core

Array = NDArray[np.float64]
Constants = dict[str, float]

STIFFNESS = 1e5
"""E0 of the samples [Pa]; their stresses are in units of it."""


@dataclass(frozen=True)
class Units:
    """Hold the unit of strain and its origin [1], and what the network is told of the snow (Y,) [1]."""

    strain: float
    origin: float
    told: tuple[float, ...]


@dataclass(frozen=True)
class Target:
    """Describe a law to be learned.

    ranges: of its constants, from low to high, drawn evenly in the logarithm; reach: the largest strain
    [units]; steps, hidden: the size of its network; units: of constants; frozen: constants of the law that
    leave its hardening as it is.
    """

    law: str
    ranges: dict[str, tuple[float, float]]
    reach: float
    steps: int
    hidden: int
    units: Callable[[Constants], Units]
    frozen: Callable[[Constants], Constants]


def _snow_units(c: Constants) -> Units:
    low, high = np.log1p(-c["theta_c"]), np.log1p(c["theta_s"])
    s, origin = (high - low) / 2, (high + low) / 2
    return Units(float(s), float(origin), (float(origin / s), float(20 * s), 4 * (c["nu"] - 0.2)))


SNOW = _core.laws()[0].name
"""The snow of Stomakhin et al. 2013, the law that a scene has if it names none."""

TARGETS = {
    SNOW: Target(
        SNOW,
        {"theta_c": (0.01, 0.04), "theta_s": (0.003, 0.012), "nu": (0.15, 0.3)},
        8.0,
        12,
        16,
        _snow_units,
        lambda c: {**c, "xi": 0.0},
    ),
}
"""Laws that are learned."""


def context(u0: Array, told: Array) -> Array:
    """Return y (n, Y): two bounded functions each of sorted strains u0 (n, 3), and what the snow tells."""
    size = np.abs(u0)
    return np.concatenate([u0 / (1 + size), u0 / (6 + size), told], axis=1)


@dataclass(frozen=True)
class Samples:
    """Hold strains u, expansion points u0 (n, 3), contexts y (n, Y), and stresses at both (n, 3)."""

    u: Array
    u0: Array
    y: Array
    T: Array
    T0: Array


def mapped(target: Target, c: Constants, u: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the stress (n, 3) that the return map leaves of strains u (n, 3), in units, and whether flow is
    plain (n,).

    Where the flow of Stomakhin et al. 2013 would make energy, Neve's return map takes another way, which
    jumps; no energy can follow, and such strains are not learned.
    """
    units = target.units(c)
    stretch = np.exp(u * units.strain + units.origin)
    F = np.zeros((len(u), 3, 3))
    F[:, range(3), range(3)] = stretch
    given = {"E0": STIFFNESS} | target.frozen(c)
    left, _, tau = _core.f64.law(target.law, "snow", given, F, np.ones(len(u)))[:3]
    T: Array = np.asarray(tau, dtype=np.float64)[:, range(3), range(3)] / (STIFFNESS * units.strain)
    plain: NDArray[np.bool_] = np.ones(len(u), dtype=bool)
    if "theta_c" in c:
        clamped = np.clip(stretch, 1 - c["theta_c"], 1 + c["theta_s"])
        plain = np.abs(np.asarray(left)[:, range(3), range(3)] - clamped).max(1) < 1e-9
    return T, plain


def _constants(target: Target, rng: np.random.Generator) -> Constants:
    ends = target.ranges.items()
    return {name: float(np.exp(rng.uniform(np.log(low), np.log(high)))) for name, (low, high) in ends}


def samples(target: Target, count: int, seed: int, each: int = 50) -> Samples:
    """Draw about `count` points and neighbours, `each` of one snow: strains from a third of a unit to the
    reach, steps from a tenth of a unit to a third of the reach.
    """
    rng = np.random.default_rng(seed)
    parts = []
    for _ in range(-(-count // each)):
        c = _constants(target, rng)
        units = target.units(c)
        size = np.exp(rng.uniform(np.log(0.3), np.log(target.reach), (each, 1)))
        u0 = -np.sort(-size * rng.uniform(-1, 1, (each, 3)), axis=1)
        step = np.exp(rng.uniform(np.log(0.1), np.log(target.reach / 3), (each, 1)))
        way = rng.normal(size=(each, 3))
        u = u0 + step * way / np.linalg.norm(way, axis=1, keepdims=True)
        (T, plain), (T0, plain0) = mapped(target, c, u), mapped(target, c, u0)
        y = context(u0, np.tile(units.told, (each, 1)))
        parts.append([a[plain & plain0] for a in (u, u0, y, T, T0)])
    return Samples(*(np.concatenate(a) for a in zip(*parts, strict=True)))
