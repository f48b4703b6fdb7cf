"""Measure what heat costs beside the steps: passes over a block of snow in the sun, by each method."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import process_time
from typing import Any

from neve import _core
from neve.bench.spread import Spread
from neve.heat.clock import INTERVAL
from neve.mpm.solver import MpmSolver
from neve.mpm.step import on_lattice
from neve.scene.schema.material import Heat
from neve.scene.schema.scene import Collider, Numerics, Scene, Source
from neve.simulation import Simulation

METHODS = ("mpm", "particles")
DX, CELLS = 0.02, (25, 10, 10)
"""Grid spacing [m], and the size of the block [cells] of 8 particles."""
WARM, STEPS, BATCHES = 20, 40, 7
"""Steps before the first batch, steps of a batch, batches; in turn with as many passes of one interval."""
SPEED = 1e4
"""Seconds of heat in a second of motion [1], as in the preset `melt`."""


@dataclass
class HeatCost:
    """Hold what heat costs by one method.

    Attributes:
        case, method: names; particles, threads, batches: sizes
        rounds: of a pass; steps: of motion between two passes
        pass_ns, step_ns: processor time of a pass, and of a step with what else it does, over the particles
        share: of all processor time that passes take [1]
    """

    case: str
    method: str
    particles: int
    threads: int
    batches: int
    rounds: int
    steps: float
    pass_ns: Spread
    step_ns: Spread
    share: float

    def text(self) -> str:
        """Return the result as lines of text."""
        whole, step = self.pass_ns, self.step_ns
        return (
            f"{self.case} {self.method}: {self.particles:,} particles, {self.threads} threads, median of "
            f"{self.batches} batches\n"
            f"  a pass of {self.rounds} rounds {whole.median:.0f} ns of processors a particle "
            f"({whole.least:.0f}-{whole.largest:.0f}), every {self.steps:.0f} steps of {step.median:.0f} ns "
            f"({step.least:.0f}-{step.largest:.0f}): {whole.median / self.steps:.1f} ns a particle and step, "
            f"{100 * self.share:.1f} % of all"
        )


def block(method: str) -> Scene:
    """Return the scene of a block of snow that lies in the sun."""
    x, y, z = (n * DX for n in CELLS)
    return Scene(
        numerics=Numerics(dx=DX, method=method, initial_volume="sampled"),
        sources=(Source.of("box", center=(0.0, 0.0, z / 2), size=(x, y, z)),),
        colliders=(Collider.of("plane"),),
        heat=Heat(heat_speed=SPEED),
    )


def passes(sim: Simulation) -> Callable[[], Any]:
    """Return what lets heat flow for one interval."""
    solver = sim.solver
    if not isinstance(solver, MpmSolver):
        solids = solver.placed.native if solver.placed else None
        return lambda: solver.state.pass_heat(INTERVAL, solids)

    def flow() -> Any:
        with on_lattice(solver.model):
            return solver.model.core.pass_heat(solver.model.native, solver.state, INTERVAL)

    return flow


def measure_heat(steps: int = STEPS, batches: int = BATCHES) -> Iterator[HeatCost]:
    """Time batches of steps and passes of heat in turn, method by method."""
    for method in METHODS:
        sim = Simulation(block(method))
        sim.advance(1e-3)
        dt = sim.stats.dt_mean
        sim.advance(WARM * dt)
        whole, step, rounds, taken = [], [], 0, 0
        flow = passes(sim)
        for _ in range(batches):
            begun, before = process_time(), sim.steps
            sim.advance(steps * dt)
            step.append(1e9 * (process_time() - begun) / (sim.count * (sim.steps - before)))
            taken += sim.steps - before
            begun = process_time()
            rounds = flow().rounds
            whole.append(1e9 * (process_time() - begun) / sim.count)
        between = INTERVAL * taken / (batches * steps * dt)
        a_pass, a_step = Spread.of(whole), Spread.of(step)
        share = a_pass.median / (a_pass.median + between * a_step.median)
        yield HeatCost(
            "heat", method, sim.count, _core.threads(), batches, rounds, between, a_pass, a_step, share
        )
