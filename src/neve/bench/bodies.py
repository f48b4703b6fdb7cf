"""Measure what rigid bodies cost: five boots in snow, many boxes on it, against the same snow alone."""

from __future__ import annotations

import statistics
import warnings
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from neve import _core
from neve.bench.spread import Spread
from neve.scene.errors import SceneWarning
from neve.scene.schema.scene import Body, Camera, Collider, Numerics, Scene, Source
from neve.simulation import Simulation

DX, DT = 0.02, 1e-4
"""Grid spacing [m] and time step [s]."""
CELLS = (60, 21, 10)
"""Size of the snow, of 8 particles a cell [1]."""
FILE, COUNT = "neve:boot", 5
"""The mesh of the bodies, and how many there are."""
SUNK = 0.04
"""How deep the boots stand in the snow at the start [m]."""
FIELD, ROWS, BOX = (100, 50, 8), (10, 5), 0.1
"""Size of the snow under the boxes, 8 particles a cell [1]; how many lie along x and y; their edge [m]."""
STEPS, BATCHES, WARM = 40, 9, 100
"""Steps of a batch, batches of each kind, steps before the first."""


@dataclass
class Share:
    """Hold what bodies cost, from batches with and without them, in turn.

    Attributes:
        case: name of the case
        particles, threads, bodies: sizes; `triangles` are those of one body
        steps, batches: as they were taken
        step_ms, bare_ms: wall time of a step with the bodies and without
        growth_ms: of each stage
        share: growth of the step over the step with bodies [1]
    """

    case: str
    particles: int
    threads: int
    bodies: int
    triangles: int
    steps: int
    batches: int
    step_ms: Spread
    bare_ms: Spread
    growth_ms: dict[str, float]
    share: Spread

    def text(self) -> str:
        """Return the result as lines of text."""
        lines = [
            f"{self.case}: {self.bodies} bodies{self._triangles} in {self.particles:,} "
            f"particles, {self.threads} threads, median of {self.batches} pairs of batches "
            f"of {self.steps} steps",
            f"  step {self.step_ms.median:.3f} ms with bodies ({self.step_ms.least:.3f}-"
            f"{self.step_ms.largest:.3f}), {self.bare_ms.median:.3f} ms without "
            f"({self.bare_ms.least:.3f}-{self.bare_ms.largest:.3f})",
            f"  bodies take {100 * self.share.median:.1f} % of the step ({100 * self.share.least:.1f}-"
            f"{100 * self.share.largest:.1f})",
        ]
        lines += [f"  {stage:6}{ms:+9.3f} ms" for stage, ms in self.growth_ms.items()]
        return "\n".join(lines)

    @property
    def _triangles(self) -> str:
        return f" of {self.triangles:,} triangles" if self.triangles else ""


def boots(cells: tuple[int, int, int], count: int, **numerics: Any) -> Scene:
    """Return the scene of a block of snow in which `count` boots stand, side by side along x."""
    x, y, z = (n * DX for n in cells)
    places = (np.arange(count) + 0.5) * x / max(count, 1) - 0.5 * x
    return Scene(
        numerics=Numerics(**{"dx": DX, "dt": DT, **numerics}),
        sources=(Source.of("box", center=(0.0, 0.0, z / 2), size=(x, y, z)),),
        colliders=(Collider.of("plane"),),
        bodies=tuple(
            Body.of(
                "mesh",
                file=FILE,
                center=(float(place), 0.0, z - SUNK),
                rotation=(0.0, 0.0, 90.0),
                density=300.0,
            )
            for place in places
        ),
        camera=Camera(position=(2 * x, -4 * x, 2 * x), target=(0.0, 0.0, z / 2)),
    )


def boxes(cells: tuple[int, int, int], rows: tuple[int, int], **numerics: Any) -> Scene:
    """Return the scene of a layer of snow on which boxes lie, as many along x and y as `rows` says."""
    x, y, z = (n * DX for n in cells)
    along, across = (
        (np.arange(n) + 0.5) * size / max(n, 1) - 0.5 * size for n, size in zip(rows, (x, y), strict=True)
    )
    return Scene(
        numerics=Numerics(**{"dx": DX, "dt": DT, **numerics}),
        sources=(Source.of("box", center=(0.0, 0.0, z / 2), size=(x, y, z)),),
        colliders=(Collider.of("plane"),),
        bodies=tuple(
            Body.of("box", size=(BOX, BOX, BOX), center=(float(a), float(b), z + BOX / 2), density=300.0)
            for a in along
            for b in across
        ),
        camera=Camera(position=(2 * x, -4 * x, 2 * x), target=(0.0, 0.0, z / 2)),
    )


def measure_bodies(
    cells: tuple[int, int, int] = CELLS, count: int = COUNT, batches: int = BATCHES, steps: int = STEPS
) -> Share:
    """Time boots in snow against the same snow alone."""
    return _measure("bodies", boots(cells, count), boots(cells, 0), batches, steps)


def measure_many(
    cells: tuple[int, int, int] = FIELD,
    rows: tuple[int, int] = ROWS,
    batches: int = BATCHES,
    steps: int = STEPS // 2,
) -> Share:
    """Time many boxes on snow against the same snow alone."""
    return _measure("many_bodies", boxes(cells, rows), boxes(cells, (0, 0)), batches, steps)


def _measure(case: str, scene: Scene, bare_scene: Scene, batches: int, steps: int) -> Share:
    """Time batches with the bodies and, from the same snow each time, batches without them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SceneWarning)  # the boots stand in the snow on purpose
        sim = Simulation(scene)
    mesh = sim.solver.solids[-1].mesh
    sim.advance(WARM * DT)
    wall: list[tuple[float, float]] = []
    growth: dict[str, list[float]] = {stage: [] for stage in sim.solver.stages}
    for _ in range(batches):
        arrays = sim.arrays()
        arrays["exchanged"] = arrays["exchanged"][:1]
        bare = Simulation.restore(bare_scene, arrays)
        bare.advance(5 * DT)  # what a new grid has to allocate
        times = [_batch(run, steps) for run in (bare, sim)]
        wall.append((times[1], times[0]))
        for stage in sim.solver.stages:
            growth[stage].append(sim.stats.stage_seconds[stage] - bare.stats.stage_seconds[stage])
    return Share(
        case=case,
        particles=int(sim.state.count),
        threads=_core.threads(),
        bodies=len(scene.bodies),
        triangles=len(mesh.faces) if mesh else 0,
        steps=steps,
        batches=batches,
        step_ms=Spread.of([1e3 * a / steps for a, _ in wall]),
        bare_ms=Spread.of([1e3 * b / steps for _, b in wall]),
        growth_ms={stage: 1e3 * statistics.median(times) / steps for stage, times in growth.items()},
        share=Spread.of([(a - b) / a for a, b in wall]),
    )


def _batch(sim: Simulation, steps: int) -> float:
    begun, before = perf_counter(), sim.steps
    sim.advance(steps * DT)
    seconds = perf_counter() - begun
    if sim.steps - before != steps:
        raise AssertionError(f"a batch took {sim.steps - before} steps, not {steps}")
    return seconds
