"""What a network learns: the return map of a law, in units that serve any stiffness.

Of Stomakhin et al. 2013: at a given hardening, that at the expansion point, which stays in the energy, as in
Li et al. 2022. The unit of strain s is that at which snow yields, so that flow begins at strains of about 1;
that of stress is E s, E the stiffness as hardened. With it the units change from one expansion to the next,
and the network serves every one. Of cam-clay: see `neve.learned.clay`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.learned import clay
from neve.learned.samples import STIFFNESS, Array, Constants, Samples, context, diagonal, joined


@dataclass(frozen=True)
class Units:
    """Hold the unit of strain and its origin [1], and what the network is told of the snow (Y,) [1]."""

    strain: float
    origin: float
    told: tuple[float, ...]


@dataclass(frozen=True)
class Target:
    """Describe a law to be learned.

    ranges: of its constants, from low to high, drawn evenly in the logarithm, or as they are where low is
    0; reach: the largest strain [units]; steps, hidden: the size of its network; draw: samples of one snow;
    samples: how many of them; each: how many of one snow.
    """

    law: str
    ranges: dict[str, tuple[float, float]]
    reach: float
    steps: int
    hidden: int
    draw: Callable[[np.random.Generator, Constants, int], Samples]
    samples: int
    each: int


def _snow_units(c: Constants) -> Units:
    low, high = np.log1p(-c["theta_c"]), np.log1p(c["theta_s"])
    s, origin = (high - low) / 2, (high + low) / 2
    return Units(float(s), float(origin), (float(origin / s), float(20 * s), 4 * (c["nu"] - 0.2)))


SNOW = _core.laws()[0].name
"""The snow of Stomakhin et al. 2013, the law that a scene has if it names none."""

REACH = 8.0
"""Largest strain of its samples [units]."""


def mapped(c: Constants, u: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the stress (n, 3) that the return map leaves of strains u (n, 3), in units, and whether flow is
    plain (n,).

    Where the flow of Stomakhin et al. 2013 would make energy, Neve's return map takes another way, which
    jumps; no energy can follow, and such strains are not learned.
    """
    units = _snow_units(c)
    F = diagonal(u * units.strain + units.origin)
    left, _, tau = _core.f64.law(SNOW, "snow", {"E0": STIFFNESS} | c | {"xi": 0.0}, F, np.ones(len(u)))[:3]
    T: Array = np.asarray(tau, dtype=np.float64)[:, range(3), range(3)] / (STIFFNESS * units.strain)
    clamped = np.clip(F[:, range(3), range(3)], 1 - c["theta_c"], 1 + c["theta_s"])
    plain: NDArray[np.bool_] = np.abs(np.asarray(left)[:, range(3), range(3)] - clamped).max(1) < 1e-9
    return T, plain


def _draw_snow(rng: np.random.Generator, c: Constants, n: int) -> Samples:
    """Draw strains from a third of a unit to the reach, steps from a tenth of a unit to a third of it."""
    size = np.exp(rng.uniform(np.log(0.3), np.log(REACH), (n, 1)))
    u0 = -np.sort(-size * rng.uniform(-1, 1, (n, 3)), axis=1)
    step = np.exp(rng.uniform(np.log(0.1), np.log(REACH / 3), (n, 1)))
    way = rng.normal(size=(n, 3))
    u = u0 + step * way / np.linalg.norm(way, axis=1, keepdims=True)
    (T, plain), (T0, plain0) = mapped(c, u), mapped(c, u0)
    y = context(u0, np.tile(_snow_units(c).told, (n, 1)))
    return Samples(*(a[plain & plain0] for a in (u, u0, y, T, T0)))


TARGETS = {
    SNOW: Target(
        SNOW,
        {"theta_c": (0.01, 0.04), "theta_s": (0.003, 0.012), "nu": (0.15, 0.3)},
        REACH,
        12,
        16,
        _draw_snow,
        4000,
        50,
    ),
    clay.LAW: Target(
        clay.LAW,
        {"xi": (0.1, 1.0), "M": (0.4, 1.5), "beta": (0.0, 0.5), "nu": (0.2, 0.35)},
        1.5,
        4,
        24,
        clay.draw,
        6000,
        10,
    ),
}
"""Laws that are learned."""


def _constants(target: Target, rng: np.random.Generator) -> Constants:
    drawn = {}
    for name, (low, high) in target.ranges.items():
        even = rng.uniform(*((np.log(low), np.log(high)) if low > 0 else (low, high)))
        drawn[name] = float(np.exp(even) if low > 0 else even)
    return drawn


def samples(target: Target, count: int, seed: int) -> Samples:
    """Draw about `count` points and neighbours."""
    rng, each = np.random.default_rng(seed), target.each
    return joined([target.draw(rng, _constants(target, rng), each) for _ in range(-(-count // each))])
