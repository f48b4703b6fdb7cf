"""What a peer needs to run the same snow, and of which scenes it can be had."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import neve
from neve.scene.schema.scene import Scene, Snow

MARGIN = (12, 12, 4)  # nodes of the dense grid around the block, and below the ground
J_P_BOUNDS = (0.6, 20.0)  # of J_P inside the hardening exponent, as in Neve


@dataclass(frozen=True)
class Case:
    """Hold what a run needs; arrays are float32, lengths in metres."""

    x: np.ndarray  # (n, 3) positions [m]
    v: np.ndarray  # (n, 3) velocities [m/s]
    m: np.ndarray  # (n,) masses [kg]
    V0: np.ndarray  # (n,) initial volumes [m3]
    dx: float  # [m]
    dt: float  # [s]
    E0: float  # [Pa]
    nu: float  # [1]
    xi: float  # [1]
    theta_c: float  # [1]
    theta_s: float  # [1]
    gravity: float  # along z [m/s2]
    mu_c: float  # friction of the ground z = 0 [1]
    low: np.ndarray  # (3,) index of the first node of the dense grid
    shape: tuple[int, int, int]  # nodes of the dense grid


def case_of(sim: neve.Simulation) -> Case:
    """Return the particles of a new simulation, and its scene."""
    scene, state = sim.scene, sim.state
    snow, numerics, ground = scene.snow, scene.numerics, scene.colliders[0]
    check(scene, snow)
    x = np.array(state.x)
    low = np.floor(x.min(axis=0) / numerics.dx).astype(int) - MARGIN
    high = np.ceil(x.max(axis=0) / numerics.dx).astype(int) + MARGIN
    return Case(
        x=x, v=np.array(state.v), m=np.array(state.m), V0=np.array(state.V0), dx=numerics.dx,
        dt=float(numerics.dt), E0=snow.E0, nu=snow.nu, xi=snow.xi, theta_c=snow.theta_c, theta_s=snow.theta_s,
        gravity=scene.world.gravity[2], mu_c=ground.mu_c,
        low=low, shape=tuple(int(n) for n in high - low + 1),
    )  # fmt: skip


def check(scene: Scene, snow: Snow) -> None:
    """Refuse a scene that the peers would not run alike."""
    numerics, ground = scene.numerics, scene.colliders[0]
    alike = (
        (snow.J_P_min, snow.J_P_max) == J_P_BOUNDS
        and (numerics.spline, numerics.transfer, numerics.precision) == ("quadratic", "apic", "float32")
        and (ground.shape, ground.mode, ground.point, ground.normal)
        == ("plane", "separate", (0, 0, 0), (0, 0, 1))
        and scene.world.gravity[:2] == (0, 0)
        and len(scene.colliders) == 1
    )
    if not alike:
        raise SystemExit("the peers do quadratic apic float32 on the ground z = 0 only")
