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
    V0: np.ndarray | None = None
    J: np.ndarray | None = None
    yield_pressure: float = np.inf  # at birth
    bond_strain: float = 0.0  # at birth


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
    """Return the damper of each contact over its stiffness (n, n) [s]: 1.5 times critical for water."""
    liquid = np.zeros(len(c.m)) if c.liquid is None else c.liquid
    reduced = c.m[:, None] * c.m[None] / (c.m[:, None] + c.m[None])
    wet = np.maximum(liquid[:, None], liquid[None])
    return np.maximum(c.damping, wet * 1.5 * 2.0 * np.sqrt(reduced / k))


def forces(c):
    """Return the force on each particle (n, 3) [N], and update what is remembered.

    Besides what compaction needs: the parts of forces across along and against the axes (n, 3), their
    sum (n,) [N], and that of the stiffness (n,) [N/m].
    """
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
    others = np.isfinite(overlap)
    normal = np.where(others, bond + pressed, 0.0)
    across = np.where(others[..., None], normal[..., None] * n, 0.0)
    force = np.sum(across + np.where((holds & others)[..., None], along, 0.0), axis=1)
    stiffness = np.sum(np.where((holds | c.bonded) & others, k, 0.0), axis=1)
    along_axes, against = (np.sum(np.maximum(a, 0.0), axis=1) for a in (across, -across))
    return force, (along_axes, against, np.sum(normal, axis=1), stiffness)


ICE, HARDENING = 917.0, 100.0


def growth(born, J):
    """Return the force that breaks bonds of snow over that at birth, of density `born`, in steps of 1 %."""
    strength = [625.0 + 3125.0 * (rho - 100.0) / 800.0 for rho in (born / J, born)]
    return 0.01 * np.floor(100.0 * strength[0] / strength[1] * J ** (2 / 3) + 0.25)


def compact(c, along, against, across, stiffness):
    """Let particles shrink that opposing forces press by more than Y(rho) pi r^2.

    Returns how strong bonds of the particles are now over those at birth (n,), and were before (n,).
    """
    born = c.m / c.V0
    force = np.linalg.norm(np.minimum(along, against), axis=1)
    bearable = c.yield_pressure * (1.0 - c.liquid) * np.exp((born / c.J - born) / HARDENING)
    bearable = bearable * np.pi * c.radius**2
    yields = (force > bearable) & (across > 0)
    excess = np.where(yields, 1.0 - bearable / np.where(force > 0, force, 1.0), 0.0)
    mean_overlap = across / np.where(stiffness > 0, stiffness, 1.0)
    smallest = c.radius * np.cbrt(np.minimum(born / c.J / ICE, 1.0))
    smaller = np.where(yields, np.maximum(c.radius - 0.5 * mean_overlap * excess, smallest), c.radius)
    before = growth(born, c.J)
    c.J, c.radius = c.J * (smaller / c.radius) ** 3, smaller
    return growth(born, c.J), before


def strengthen(c, now, before):
    """Let bonds and contacts bear as much more as their particles; not those that the next step breaks."""
    pair = lambda a: a[:, None] + a[None]  # noqa: E731
    c.bond = c.bond_strain * (1.0 - c.liquid) * now / np.cbrt(c.J)
    overlap = pairs(c)[1]
    whole = np.where(c.bonded, c.rest - overlap <= c.hold, c.touching & (overlap > -c.hold))
    c.hold = np.where(whole & (c.hold > np.finfo(float).tiny), c.hold * pair(now) / pair(before), c.hold)


def step(c, dt, gravity):
    """Advance by dt [s] without solids: v += dt (F / m + g), x += dt v."""
    force, sums = forces(c)
    grown = compact(c, *sums) if c.J is not None else None
    c.v = c.v + dt * (force / c.m[:, None] + gravity)
    c.x = c.x + dt * c.v
    c.last_dt = dt
    if grown:
        strengthen(c, *grown)
