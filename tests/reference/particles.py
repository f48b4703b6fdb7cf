"""Particles in contact, written from docs/particles.md: pairs in plain NumPy, all at once, without lists.

Memory is held in matrices over all pairs: what a bond or a contact may be stretched, the overlap at rest of a
bond, and the spring of friction (n, n, 3), antisymmetric.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Cluster:
    """Particles, their constants, and what is remembered of their pairs."""

    x: np.ndarray
    v: np.ndarray
    m: np.ndarray
    radius: np.ndarray
    k: np.ndarray
    mu: np.ndarray
    bond: np.ndarray
    bonded: np.ndarray  # (n, n) bool
    rest: np.ndarray  # (n, n) overlap of a bond at rest
    hold: np.ndarray  # (n, n) how far a bond or a contact may be stretched
    touching: np.ndarray  # (n, n) bool
    spring: np.ndarray  # (n, n, 3)
    damping: float
    tangential: float
    last_dt: float
    liquid: np.ndarray | None = None


def pairs(c):
    """Return distance vectors n (n, n, 3), overlap, stiffness, speed apart, velocity along (n, n, 3)."""
    d = c.x[:, None] - c.x[None]
    far = np.linalg.norm(d, axis=2) + np.eye(len(c.x))
    n = d / far[..., None]
    dv = c.v[:, None] - c.v[None]
    v_n = np.sum(dv * n, axis=2)
    overlap = c.radius[:, None] + c.radius[None] - far
    np.fill_diagonal(overlap, -np.inf)
    return n, overlap, 0.5 * (c.k[:, None] + c.k[None]), v_n, dv - n * v_n[..., None]


def damper_times(c, k):
    """Return the damper of each contact over its stiffness (n, n) [s]: that of water is 1.5 times critical."""
    liquid = np.zeros(len(c.m)) if c.liquid is None else c.liquid
    reduced = c.m[:, None] * c.m[None] / (c.m[:, None] + c.m[None])
    wet = np.maximum(liquid[:, None], liquid[None])
    return np.maximum(c.damping, wet * 1.5 * 2.0 * np.sqrt(reduced / k))


def forces(c):
    """Return the force on each particle (n, 3) [N], and update what is remembered."""
    n, overlap, k, v_n, v_t = pairs(c)
    c.bonded &= ~(c.rest - overlap > c.hold)
    bond = np.where(c.bonded, k * (overlap - c.rest - c.damping * v_n), 0.0)

    touching = ~c.bonded & ((overlap > 0) | c.touching)
    coheres = (c.bond[:, None] > 0) & (c.bond[None] > 0)
    sticks = np.where(coheres, 0.5 * (c.bond[:, None] + c.bond[None]), 0.0)
    sticks = sticks * (c.radius[:, None] + c.radius[None])
    gap = np.where(c.touching, c.hold, 0.0)
    gap = np.where(overlap > sticks, np.maximum(gap, sticks), gap)
    holds = touching & (overlap > -np.maximum(gap, np.finfo(float).tiny))
    damped = np.maximum(k * (overlap - damper_times(c, k) * v_n), 0.0)
    pressed = np.where(holds, np.where(overlap > 0, damped, k * overlap), 0.0)

    spring = np.where(c.touching[..., None], c.spring, 0.0) + v_t * c.last_dt
    spring -= n * np.sum(spring * n, axis=2, keepdims=True)
    rubs = (c.mu[:, None] > 0) & (c.mu[None] > 0)
    most = np.where(rubs, 0.5 * (c.mu[:, None] + c.mu[None]), 0.0) * np.maximum(pressed, 0.0)
    pull = k * c.tangential * np.linalg.norm(spring, axis=2)
    slips = pull > most
    spring *= np.where(slips, most / np.where(slips, pull, 1.0), 1.0)[..., None]
    elastic = -(k * c.tangential)[..., None] * spring
    both = elastic - (k * c.damping)[..., None] * v_t
    along = np.where((np.linalg.norm(both, axis=2) <= most)[..., None], both, elastic)

    c.touching, c.hold = holds, np.where(c.bonded, c.hold, np.where(holds, gap, 0.0))
    c.spring = np.where(holds[..., None], spring, 0.0)
    across = (bond + pressed)[..., None] * n
    return np.sum(
        np.where(np.isfinite(overlap)[..., None], across + np.where(holds[..., None], along, 0.0), 0.0),
        axis=1,
    )


def step(c, dt, gravity):
    """Advance by dt [s] without solids and compaction: v += dt (F / m + g), x += dt v."""
    c.v = c.v + dt * (forces(c) / c.m[:, None] + gravity)
    c.x = c.x + dt * c.v
    c.last_dt = dt
