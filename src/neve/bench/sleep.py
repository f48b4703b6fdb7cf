"""Measure what snow at rest costs: a field with one rolling wheel, where most snow sleeps or none does."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from time import perf_counter

from neve import _core
from neve.bench.spread import Spread
from neve.scene.errors import SceneWarning
from neve.scene.schema.scene import Camera, Collider, Numerics, Scene, Snow, Source
from neve.simulation import Simulation

DX, DEPTH = 0.1, 0.4
"""Grid spacing, and depth of the snow [m]."""
RADIUS, SPEED, SUNK = 0.4, 2.0, 0.12
"""Of the wheel [m], of its axle [m/s], and how deep it stands in the snow [m]."""
SETTLED = 0.3
"""Time that the snow is given to come to rest [s]."""
SECONDS, AWAKE_SHARE, BATCHES = 0.03, 0.1, 5
"""Time of a batch [s], share of it in which the snow is kept awake [1], and how many of each there are."""


@dataclass
class Sleepers:
    """Hold what a step costs where snow sleeps and where it does not, from batches in turn.

    Attributes:
        case: name of the case
        particles, threads, batches: sizes
        asleep: share of the particles that sleep [1]
        step_ms, awake_ms: wall time of a step with sleep and without
        share: the former over the latter [1]
    """

    case: str
    particles: int
    threads: int
    batches: int
    asleep: float
    step_ms: Spread
    awake_ms: Spread
    share: Spread

    def text(self) -> str:
        """Return the result as lines of text."""
        step, awake, share = self.step_ms, self.awake_ms, self.share
        return (
            f"{self.case}: {self.particles:,} particles, {100 * self.asleep:.1f} % of them asleep, "
            f"{self.threads} threads, median of {self.batches} pairs of batches\n"
            f"  step {step.median:.3f} ms ({step.least:.3f}-{step.largest:.3f}); "
            f"{awake.median:.3f} ms if none sleeps ({awake.least:.3f}-{awake.largest:.3f})\n"
            f"  it costs {100 * share.median:.1f} % of that ({100 * share.least:.1f}-"
            f"{100 * share.largest:.1f})"
        )


def field(size: tuple[float, float], sleep: bool) -> Scene:
    """Return the scene of a wheel that rolls along x over a field of snow of `size` [m]."""
    length, width = size
    start = (RADIUS + 1.0 - 0.5 * length, 0.0, DEPTH + RADIUS - SUNK)
    wheel = Collider.of(
        "cylinder",
        center=start,
        radius=RADIUS,
        height=0.3,
        rotation=(90.0, 0.0, 0.0),
        velocity=(SPEED, 0.0, 0.0),
        spin=(0.0, SPEED / RADIUS, 0.0),
    )
    return Scene(
        numerics=Numerics(dx=DX, sleep=sleep),
        snow=Snow.model_validate({"E0": 1e6}),
        sources=(Source.of("box", center=(0.0, 0.0, DEPTH / 2), size=(length, width, DEPTH)),),
        colliders=(Collider.of("plane", mode="sticky"), wheel),
        camera=Camera(position=(0.0, -length, length), target=(0.0, 0.0, 0.0)),
    )


def measure_sleep(size: tuple[float, float] = (50.0, 10.0), batches: int = BATCHES) -> Sleepers:
    """Time batches of a field at rest and, from the same snow each time, batches in which none sleeps."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # the wheel stands in the snow on purpose
        sim = Simulation(field(size, True))
    for _ in range(3):
        sim.advance(SETTLED / 3)
    asleep, times = [], []
    for _ in range(batches):
        awake = Simulation.restore(sim.scene, sim.arrays())
        awake.change(field(size, False))
        awake.advance(1e-4)  # what a new grid has to allocate
        times.append((_step(sim, SECONDS), _step(awake, SECONDS * AWAKE_SHARE)))
        asleep.append(sim.diagnostics().asleep / sim.count)
    return Sleepers(
        case="sleep",
        particles=sim.count,
        threads=_core.threads(),
        batches=batches,
        asleep=min(asleep),
        step_ms=Spread.of([1e3 * a for a, _ in times]),
        awake_ms=Spread.of([1e3 * b for _, b in times]),
        share=Spread.of([a / b for a, b in times]),
    )


def _step(sim: Simulation, seconds: float) -> float:
    """Return the wall time of a step [s], all in, over `seconds` of simulated time."""
    begun, before = perf_counter(), sim.steps
    sim.advance(seconds)
    return (perf_counter() - begun) / (sim.steps - before)
