"""What a network learns of cam-clay: its return map with the hardening of the step in it.

Flow is associated, so that the stiffness is symmetric but for the length of a step, hardening or not: an
energy comes near. It must have hardening in it. What xi = 1 hardens by is as stiff as elastic snow, and an
energy at fixed hardening lets snow that is crushed be pressed for nothing.

Strains are measured in the shape of the ellipse, deviators over that of its aspect, in which every ellipse
looks like a circle: what is left of M and nu is one number, k of `core/constitutive/cam_clay.hpp`. Their unit
is sqrt(s^2 + |e0|^2), with s = p0 / K at the start of the step and e0 the strains at the expansion point.
Snow that has softened yields at strains of 1e-6, and does with strains of 1e-3 what it does with 1e-2: in
these units all strains are about one, and the network is told s. Stresses are in K times the unit.
"""

from __future__ import annotations

import numpy as np

from neve import _core
from neve.learned.samples import STIFFNESS, Array, Constants, Samples, context, diagonal

LAW = "cam_clay"

UNITS = (1e-5, 0.05)
"""Units of the samples [1]."""

LEAST_SHARE = 2e-3
"""s below which the network is told no less [units]."""


def ellipse(c: Constants) -> tuple[float, float, float]:
    """Return K / E0, k and the aspect of the ellipse in strains [1]."""
    bulk, shear = 1 / (3 * (1 - 2 * c["nu"])), 1 / (2 * (1 + c["nu"]))
    slope2 = c["M"] ** 2 / (1 + 2 * c["beta"])
    return bulk, slope2 * bulk / (3 * shear), float(np.sqrt(slope2 / 6)) * bulk / shear


def with_deviator(u: Array, factor: float) -> Array:
    """Return u (n, 3) with its deviator times `factor`."""
    third = u.mean(1, keepdims=True)
    out: Array = third + factor * (u - third)
    return out


def told(share: Array, c: Constants) -> Array:
    """Return what the network is told (n, 5) of s (n, 1) [units] and the snow, as the core does."""
    snow = (np.log(c["xi"]), np.log(ellipse(c)[1]) / 2, 2 * c["beta"])
    of_share = np.concatenate([share, np.log(np.maximum(share, LEAST_SHARE)) / 6], axis=1)
    return np.concatenate([of_share, np.tile(snow, (len(share), 1))], axis=1)


def stress(c: Constants, strain: Array, w: Array) -> Array:
    """Return tau / K (n, 3) of strains (n, 3), both in the ellipse's shape, of snow whose asinh(p0 / K) is w
    (n,) at the start.
    """
    bulk, _, aspect = ellipse(c)
    yields = 1e-3
    J_P = np.exp((np.arcsinh(yields) - w) / c["xi"])
    given = {"E0": STIFFNESS, "p0": yields * bulk * STIFFNESS, "J_P_min": 1e-20, "J_P_max": 1e20} | c
    F = diagonal(with_deviator(strain, aspect))
    tau = np.asarray(_core.f64.law(LAW, "snow", given, F, J_P)[2], dtype=np.float64)
    return with_deviator(tau[:, range(3), range(3)] / (bulk * STIFFNESS), aspect)


def _directions(rng: np.random.Generator, n: int) -> Array:
    way = rng.normal(size=(n, 3))
    out: Array = way / np.linalg.norm(way, axis=1, keepdims=True)
    return out


def draw(rng: np.random.Generator, c: Constants, n: int) -> Samples:
    """Draw n points of a snow and neighbours: four of five of snow that has softened, by up to 500 times,
    steps from a thirtieth of a unit to one.

    Where the energy is expanded is not told: with hardening in it, one serves.
    """
    unit = np.exp(rng.uniform(np.log(UNITS[0]), np.log(UNITS[1]), (n, 1)))
    soft = np.exp(rng.uniform(np.log(LEAST_SHARE), 0, (n, 1)))
    share = np.where(rng.random((n, 1)) < 0.8, soft, rng.uniform(0, 1, (n, 1)))
    u0 = -np.sort(-np.sqrt(1 - share**2) * _directions(rng, n), axis=1)
    u = u0 + np.exp(rng.uniform(np.log(0.03), 0, (n, 1))) * _directions(rng, n)
    w = np.arcsinh(share * unit)[:, 0]
    T, T0 = (stress(c, at * unit, w) / unit for at in (u, u0))
    return Samples(u, u0, context(0 * u0, told(share, c)), T, T0)
