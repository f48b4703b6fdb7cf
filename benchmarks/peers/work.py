"""The work that is measured: a block of snow that lands on the ground, of `neve bench`."""

from __future__ import annotations

import numpy as np
from case import J_P_BOUNDS, Case

import neve
from neve.bench.run import landing_block

MARGIN = (12, 12, 4)  # nodes of the dense grid around the block, and below the ground


def case_of(cells: tuple[int, int, int]) -> Case:
    """Return a block of `cells` cells as peers take it."""
    sim = neve.Simulation(landing_block(cells))
    scene, state = sim.scene, sim.state
    snow, numerics, ground = scene.snow, scene.numerics, scene.colliders[0]
    if (snow.J_P_min, snow.J_P_max) != J_P_BOUNDS:
        raise SystemExit("the peers bound J_P where Neve did; benchmarks/peers/case.py is older than the law")
    x = np.array(state.x)
    low = np.floor(x.min(axis=0) / numerics.dx).astype(int) - MARGIN
    high = np.ceil(x.max(axis=0) / numerics.dx).astype(int) + MARGIN
    return Case(
        x=x, v=np.array(state.v), m=np.array(state.m), V0=np.array(state.V0),
        low=low, shape=tuple(int(n) for n in high - low + 1), cells=cells,
        dx=numerics.dx, dt=float(numerics.dt), rho0=snow.rho0, E0=snow.E0, nu=snow.nu, xi=snow.xi,
        theta_c=snow.theta_c, theta_s=snow.theta_s, gravity=scene.world.gravity[2], mu_c=ground.mu_c,
    )  # fmt: skip
