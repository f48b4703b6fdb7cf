"""Run random scenes and judge them: no crash, no NaN, nothing lost, mass exact, no energy from nowhere."""

from __future__ import annotations

import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from neve.diagnostics import Diagnostics
from neve.mpm.blowup import Blowup
from neve.scene.scene import Scene
from neve.simulation import Simulation
from neve.stress.draw import draw

PARTS = 6
"""So often in its duration a scene is looked at."""

MOST_GAIN = 0.05
"""Growth of energy that is allowed, as a share of all that was put in."""

UNBOUNDED = ("asflip",)
"""Transfers whose energy has no bound: ASFLIP gives a particle back what the grid did not take over of its
velocity, while its affine velocity already holds a part of that. Where grains pass through each other it
gains."""

PATIENCE = 60.0
"""Wall time [s] after which a scene is stopped and counts as stuck."""


@dataclass(frozen=True)
class Outcome:
    """What became of one scene.

    fault: what went wrong, "" if nothing did; gain: largest growth of energy over all that was put in [1],
    None for a transfer whose energy has no bound; refusals: steps that were refused and tried again.
    """

    number: int
    situation: str
    description: str
    particles: int
    steps: int
    refusals: int
    gain: float | None
    seconds: float
    fault: str


def campaign(seed: int, scenes: int, threads: int | None = None) -> Iterator[Outcome]:
    """Run the scenes 0 to `scenes` - 1 of the campaign `seed`."""
    for number in range(scenes):
        yield endure(seed, number, threads)


def endure(seed: int, number: int, threads: int | None = None) -> Outcome:
    """Run scene `number` of the campaign `seed`; whatever it raises is a fault of the outcome."""
    scene, situation = draw(seed, number)
    started = time.perf_counter()
    trial = _Trial(scene)
    try:
        fault = trial.run(threads, started)
    except Blowup as stop:
        fault = f"gave up: {stop}"
    except Exception as error:  # a crash is what the campaign looks for
        fault = f"crashed: {traceback.format_exception_only(error)[-1].strip()}"
    numerics = scene.numerics
    laws = "+".join(dict.fromkeys(scene.snow_of(source).law for source in scene.sources))
    return Outcome(
        number=number,
        situation=situation,
        description=", ".join(
            (laws, numerics.transfer, numerics.spline, numerics.precision, f"dx {numerics.dx:.2g}")
        ),
        particles=trial.particles,
        steps=trial.steps,
        refusals=trial.refusals,
        gain=None if numerics.transfer in UNBOUNDED else trial.gain,
        seconds=time.perf_counter() - started,
        fault=fault,
    )


class _Trial:
    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.particles = self.steps = self.refusals = 0
        self.gain = 0.0

    def run(self, threads: int | None, started: float) -> str:
        sim = Simulation(self.scene, threads=threads)
        self.particles = sim.state.count
        if self.scene.about.endswith("coincident"):
            _stack(sim)
        mass, start = _mass_by_id(sim), sim.diagnostics()
        budget = Budget(start)
        for _ in range(PARTS):
            sim.advance(self.scene.run.duration / PARTS)
            self.steps = sim.steps
            self.refusals += sim.stats.refusals
            fault = _fault(sim, mass)
            if fault:
                return fault
            self.gain = max(self.gain, budget.gain(sim.diagnostics()))
            if self.gain > MOST_GAIN and self.scene.numerics.transfer not in UNBOUNDED:
                return f"energy grew by {100 * self.gain:.3g} % of what was put in"
            if time.perf_counter() - started > PATIENCE:
                return f"stuck: {sim.steps} steps in {PATIENCE:g} s"
        return ""


class Budget:
    """The energy that was put into the snow of a run, and what cannot be accounted for."""

    def __init__(self, start: Diagnostics) -> None:
        self._start = start
        self._put_in = start.kinetic + start.affine + start.elastic

    def gain(self, now: Diagnostics) -> float:
        """Return the growth of energy that neither colliders nor gravity gave, as a share of all that was put
        in.

        Put in are the energy at the start, the work of colliders, and what the snow fell. A growth below the
        rounding of the potential, which is a small difference of large sums, counts as none.
        """
        start = self._start
        fallen = start.potential - now.potential
        self._put_in = max(
            self._put_in, start.kinetic + start.affine + start.elastic + max(now.work, 0.0) + max(fallen, 0.0)
        )
        rounding = 1e-6 * (abs(start.potential) + abs(now.potential))
        growth = now.energy - start.energy - now.work - rounding
        return max(growth, 0.0) / max(self._put_in, 1e-300)


def _stack(sim: Simulation) -> None:
    """Put every tenth particle exactly on top of the one before it."""
    x = sim.state.x
    x[1::10] = x[0::10][: len(x[1::10])]


def _mass_by_id(sim: Simulation) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    state = sim.state
    return np.asarray(state.m, dtype=np.float64)[np.argsort(state.id)]


def _fault(sim: Simulation, mass: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    state = sim.state
    for name in ("x", "v", "C", "F_E", "J_P"):
        if not np.all(np.isfinite(getattr(state, name))):
            return f"{name} is not finite after {sim.steps} steps"
    if not np.array_equal(np.sort(state.id), np.arange(len(mass))):
        return "a particle was lost"
    if not np.array_equal(_mass_by_id(sim), mass):
        return "a particle changed its mass"
    return ""
