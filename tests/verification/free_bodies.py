"""Rigid bodies for tests of the contact alone: free balls and boxes, moved by the textbook's equations."""

import numpy as np

from neve._core import BodyMotion
from neve.colliders.solid import Solid
from neve.geometry.pose import Pose, rotation_matrix
from neve.mpm.initial import build
from neve.mpm.model import Model
from neve.mpm.state import fit_modes, from_arrays, to_arrays
from neve.simulation import Simulation


def ball(radius, density, **motion):
    """A ball: solid, mass, inertia about each axis."""
    m = density * 4 / 3 * np.pi * radius**3
    return Free(
        Solid("ball", "sphere", np.full(3, radius), motion="dynamic"),
        m,
        np.full(3, 0.4 * m * radius**2),
        **motion,
    )


def block(size, density, mode="separate", mu_c=0.5, **motion):
    """A box."""
    a, b, c = size
    m = density * a * b * c
    inertia = m / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    half = 0.5 * np.asarray(size)
    return Free(Solid("block", "box", half, mode, mu_c, motion="dynamic"), m, inertia, **motion)


class Free:
    """One body: its solid, mass [kg], principal moments [kg m2], and its motion."""

    def __init__(self, solid, mass, inertia, x=(0, 0, 0), v=(0, 0, 0), w=(0, 0, 0)):
        self.solid, self.mass, self.inertia = solid, mass, inertia
        self.x, self.v, self.w = (np.array(a, float) for a in (x, v, w))
        self.R = np.eye(3)

    @property
    def I(self):  # noqa: E743
        return self.R @ np.diag(self.inertia) @ self.R.T


class FreeBodies:
    """Newton's and Euler's equations by symplectic Euler; angular momentum is what is kept exactly."""

    def __init__(self, *bodies, gravity=(0, 0, 0)):
        self.bodies, self.gravity = bodies, np.array(gravity, float)
        self.solids = tuple(b.solid for b in bodies)

    def poses(self):
        return [Pose(b.x.copy(), b.R.copy(), b.v.copy(), b.w.copy()) for b in self.bodies]

    @property
    def motion(self):
        n = len(self.bodies)
        rates = np.array([[*b.v, *b.w] for b in self.bodies])
        mobility = np.zeros((6 * n, 6 * n))
        for i, b in enumerate(self.bodies):
            mobility[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] = np.eye(3) / b.mass
            mobility[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] = np.linalg.inv(b.I)
        falls = np.array([[*self.gravity, 0, 0, 0] for _ in self.bodies], dtype=float)
        x, R = np.array([b.x for b in self.bodies]), np.array([b.R for b in self.bodies])
        return BodyMotion(x, R, rates, mobility, falls)

    def advance(self, dt, exchanged, time):
        for b, e in zip(self.bodies, exchanged, strict=True):
            L = b.I @ b.w + e[3:6]
            b.v += e[:3] / b.mass + dt * self.gravity
            b.x += dt * b.v
            b.R = rotation_matrix(dt * b.w) @ b.R
            b.w = np.linalg.solve(b.I, L)

    @property
    def momentum(self):
        return sum(b.mass * b.v for b in self.bodies)

    @property
    def kinetic(self):
        return sum(0.5 * b.mass * b.v @ b.v + 0.5 * b.w @ b.I @ b.w for b in self.bodies)

    energy = kinetic

    @property
    def potential(self):
        return -sum(b.mass * b.x @ self.gravity for b in self.bodies)


def simulate_with(scene, bodies):
    """Return a simulation of the scene in which `bodies` take part."""
    sim = Simulation(scene, threads=1)
    plain, _, _ = build(scene)
    sim.solver.placed = Model(
        scene.world, scene.numerics, plain.snows, scene.colliders, (*plain.solids, *bodies.solids), bodies
    )
    arrays = to_arrays(sim.state)
    modes = fit_modes(arrays["modes"], arrays["modes"].shape[1], sim.solver.model.native)
    sim.solver.state = from_arrays(sim.solver.model.core, arrays | {"modes": modes})
    sim.exchanged = np.zeros((len(sim.solver.solids), 7))
    return sim
