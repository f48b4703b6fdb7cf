"""Take part in what the engine moves: pull solids by springs, hold the controls of motors and actuators."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.geometry.pose import Pose, cross
from neve.reproducible import product

Array = NDArray[np.float64]

RATE = 12.0
"""Angular frequency of the spring with all that hangs together at its end [rad/s]."""

MOST_PULL = 20.0
"""Greatest force of a spring, in weights of all that hangs together."""

WEIGHT = 9.81
"""Acceleration that a weight is reckoned with [m/s2]."""


@dataclass(frozen=True, eq=False)
class Spring:
    """Pull a point of a solid towards a target.

    grip: the point in the solid's own frame [m], (3,); target: in the world [m], (3,)
    """

    grip: Array
    target: Array


@dataclass
class Hand:
    """Hold what somebody does to the bodies of a run; a run of its own has none, and its bits are as without.

    springs: by the name of the solid; controls: values of actuators by name, in place of the scene's
    """

    springs: dict[str, Spring] = field(default_factory=dict)
    controls: dict[str, float] = field(default_factory=dict)

    def impulses(
        self, solids: Sequence[Solid], poses: Sequence[Pose], masses: Array, trees: Array, dt: float
    ) -> Array:
        """Return what the springs give each solid in dt [s], (n, 7).

        That is an impulse [N s], its moment about the origin of the frame [N m s], and 0.

        The force on the grip, at p with the velocity u, is k (target - p) - c u, at most MOST_PULL weights:
        critically damped with the mass M of the tree that the solid belongs to, k = M RATE^2 and
        c = 2 M RATE. A solid of mass m that is much lighter than its tree would overshoot in a step, so
        k <= m / (4 dt^2) and c <= m / (2 dt).

        masses: of the body of each solid [kg], (n,). trees: of its whole tree [kg], (n,)
        """
        given = np.zeros((len(solids), 7))
        for i, (solid, pose) in enumerate(zip(solids, poses, strict=True)):
            spring = self.springs.get(solid.name)
            if spring is None:
                continue
            k = min(trees[i] * RATE**2, 0.25 * masses[i] / dt**2)
            c = min(2.0 * trees[i] * RATE, 0.5 * masses[i] / dt)
            arm = product(pose.rotation, spring.grip)
            force = k * (spring.target - pose.position - arm) - c * (
                pose.velocity + np.cross(pose.omega, arm)
            )
            force *= min(1.0, MOST_PULL * WEIGHT * trees[i] / max(math.hypot(*force), 1e-300))
            given[i, :3], given[i, 3:6] = force * dt, cross(arm, force) * dt
        return given
