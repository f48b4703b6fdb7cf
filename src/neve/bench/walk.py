"""Measure the scene that is made to be played with: pictures a second, and what a step costs."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from time import perf_counter, process_time

from neve import _core
from neve.bench.spread import Spread
from neve.scene.errors import SceneWarning
from neve.scene.reading.load import load
from neve.scene.schema.scene import Scene
from neve.simulation import Simulation

FPS = 30
"""Pictures a second of real time."""
SETTLED, PICTURES = 1.0, 30
"""Time in which the fresh layer comes to rest while the boots walk [s], and the pictures that follow it."""


@dataclass
class Walk:
    """Hold what pictures of the scene cost, one after another.

    Attributes:
        case: name of the case
        particles, threads, pictures, steps: sizes; steps of a picture, the median
        asleep: share of the particles that sleep, the median over the pictures [1]
        wall_ms, cpu_ms: time of a picture, 1/FPS s of motion: by the clock, and of the processors
        step_ns, mpm_ns: processor time over awake particles and steps, and the same of the material point
            method, whose particles are all awake
        stage_ms: time of each stage of a picture by the clock, the mean over the pictures; "other" is what is
            left of the whole
    """

    case: str
    particles: int
    threads: int
    pictures: int
    steps: float
    asleep: float
    wall_ms: Spread
    cpu_ms: Spread
    step_ns: Spread
    mpm_ns: float
    stage_ms: dict[str, float] = field(default_factory=dict)

    def text(self) -> str:
        """Return the result as lines of text."""
        wall, cpu, cost = self.wall_ms, self.cpu_ms, self.step_ns
        return (
            f"{self.case}: {self.particles:,} particles, {100 * self.asleep:.1f} % of them asleep, "
            f"{self.threads} threads, median of {self.pictures} pictures of {self.steps:.0f} steps\n"
            f"  picture {wall.median:.1f} ms ({wall.least:.1f}-{wall.largest:.1f}), "
            f"{cpu.median:.1f} ms of processors ({cpu.least:.1f}-{cpu.largest:.1f}): "
            f"{1e3 / wall.median:.1f} pictures/s, real time is {FPS}\n"
            f"  {cost.median:.0f} ns of processors a step of an awake particle, all in "
            f"({cost.least:.0f}-{cost.largest:.0f}); material points {self.mpm_ns:.0f} ns\n"
            + f"  {'stage':<12}{'ms/picture':>12}{'us/step':>12}\n"
            + "\n".join(
                f"  {name:<12}{ms:>12.2f}{1e3 * ms / self.steps:>12.1f}" for name, ms in self.stage_ms.items()
            )
        )


def measure_walk(
    mpm_ns: Callable[[], float],
    scene: Scene | None = None,
    settled: float = SETTLED,
    pictures: int = PICTURES,
) -> Walk:
    """Let the boots of `walk_live` walk and time picture after picture.

    mpm_ns: measures the processor time of a step of the material point method over its particles [ns].
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)
        sim = Simulation(scene or load("walk_live"))
    while sim.time < settled:
        sim.advance(1 / FPS)
    wall, cpu, cost, asleep, steps = [], [], [], [], []
    stages = dict.fromkeys((*sim.solver.stages, "other"), 0.0)
    for _ in range(pictures):
        begun, spent = perf_counter(), process_time()
        sim.advance(1 / FPS)
        wall.append(1e3 * (perf_counter() - begun))
        cpu.append(1e3 * (process_time() - spent))
        spans = {name: 1e3 * seconds for name, seconds in sim.stats.stage_seconds.items()}
        for name, ms in {**spans, "other": wall[-1] - sum(spans.values())}.items():
            stages[name] += ms / pictures
        sleepers = sim.diagnostics().asleep
        asleep.append(sleepers / sim.count)
        steps.append(float(sim.stats.steps))
        cost.append(1e6 * cpu[-1] / (max(sim.count - sleepers, 1) * sim.stats.steps))
    return Walk(
        case="walk",
        particles=sim.count,
        threads=_core.threads(),
        pictures=pictures,
        steps=Spread.of(steps).median,
        asleep=Spread.of(asleep).median,
        wall_ms=Spread.of(wall),
        cpu_ms=Spread.of(cpu),
        step_ns=Spread.of(cost),
        mpm_ns=mpm_ns(),
        stage_ms=stages,
    )
