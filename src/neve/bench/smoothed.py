"""Measure what a second of snow costs as smoothed particles, and by the material point method beside it."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np

from neve.scene.errors import SceneWarning
from neve.scene.schema.scene import Collider, Numerics, Scene, Snow, Source
from neve.simulation import Simulation

SPACING, SIDE = 0.05, 37
"""Distance of particles [m], and how many there are along each edge of the block: 50,653."""
SPEED = 1.0
"""Speed at which the block lands [m/s]."""
STIFF = (1.4e5, 5e6)
"""Young's moduli of the snow [Pa]."""
WARM, SECONDS = 0.06, {"sph": 0.06, "mpm": 0.02}
"""Time before what is measured, in which the block lands, and of what is measured [s]."""


@dataclass
class Cost:
    """Hold the processor time of a block that lands, by one method.

    Attributes:
        case: name of the case
        method: `numerics.method`
        particles, threads, steps: sizes
        E0: Young's modulus [Pa]
        dt: mean time step [s]
        bound: what bound most steps
        iterations: means of both solves, none for a method without
        step_s, second_s: processor time of a step, and of a simulated second [s]
    """

    case: str
    method: str
    particles: int
    threads: int
    steps: int
    E0: float
    dt: float
    bound: str
    iterations: tuple[float, float] | None
    step_s: float
    second_s: float

    def text(self) -> str:
        """Return the result as a line of text."""
        solves = "{:.0f} and {:.0f} iterations, ".format(*self.iterations) if self.iterations else ""
        return (
            f"{self.case} {self.method}, E0 = {self.E0:.3g} Pa: {self.particles:,} particles, "
            f"{self.threads} threads, {self.steps} steps of {1e3 * self.dt:.3g} ms ({self.bound}), {solves}"
            f"{self.step_s:.3g} s of processor time a step, {self.second_s:.3g} s a simulated second"
        )


def landing(method: str, E0: float, side: int = SIDE) -> Scene:
    """Return the scene of a block of side^3 particles that is one spacing above the ground."""
    size = side * SPACING
    lattice = {"sampling": "regular", "dt": "auto", "precision": "float32"}
    cells = {"dx": SPACING, "particles_per_cell": 1} if method == "sph" else {"dx": 2 * SPACING}
    box = {"center": (0.0, 0.0, size / 2 + SPACING), "size": (size, size, size)}
    return Scene(
        numerics=Numerics.model_validate({"method": method, **lattice, **cells}),
        snow=Snow.model_validate({"E0": E0}),
        sources=(Source.of("box", **box, velocity=(0.0, 0.0, -SPEED)),),
        colliders=(Collider.of("plane"),),
    )


def measure_cost(method: str, E0: float, side: int = SIDE) -> Cost:
    """Let the block land and time it, on one thread: others that wait take processor time as well."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        sim = Simulation(landing(method, E0, side), threads=1)
    sim.advance(WARM)
    steps, seconds = sim.steps, SECONDS[method]
    bounds: Counter[str] = Counter()
    begun = process_time()
    solves = []
    for _ in range(4):
        sim.advance(seconds / 4)
        bounds[sim.stats.bound] += sim.stats.steps
        if method == "sph":
            solves.append(sim.diagnostics().solves)
    spent = process_time() - begun
    steps = sim.steps - steps
    iterations = None
    if solves:
        means = [(one.pressure_iterations, one.shear_iterations) for one in solves]
        pressure, shear = np.mean(means, axis=0)
        iterations = (float(pressure), float(shear))
    return Cost(
        "smoothed",
        method,
        sim.count,
        1,
        steps,
        E0,
        seconds / steps,
        bounds.most_common(1)[0][0],
        iterations,
        spent / steps,
        spent / seconds,
    )


def measure_smoothed() -> Iterator[Cost]:
    """Measure soft and stiff snow by both methods."""
    for E0 in STIFF:
        for method in SECONDS:
            yield measure_cost(method, E0)
