"""Measure what loose snow costs: the particles of a block scattered in the air, against the block itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neve import _core
from neve.bench.spread import Spread
from neve.scene.schema.scene import Camera, Numerics, Scene, Source
from neve.simulation import Simulation

DX, DT = 0.02, 1e-4
"""Grid spacing [m] and time step [s]."""
CELLS = (25, 10, 10)
"""Size of the block, of 8 particles a cell [1]."""
LOOSE = 0.2
"""Particles a cell of the scattered snow [1]."""
STEPS, BATCHES, WARM = 10, 9, 40
"""Steps of a batch, batches of each kind, steps before the first."""


@dataclass
class Scattered:
    """Hold what a particle costs in loose snow and in dense snow, from batches in turn.

    Attributes:
        case: name of the case
        particles, threads, steps, batches: sizes
        per_cell: particles a cell of the loose snow [1]
        loose_ns, dense_ns: wall time per particle and step
        ratio: the former over the latter [1]
        growth_ns: of each stage
    """

    case: str
    particles: int
    threads: int
    steps: int
    batches: int
    per_cell: float
    loose_ns: Spread
    dense_ns: Spread
    ratio: Spread
    growth_ns: dict[str, float]

    def text(self) -> str:
        """Return the result as lines of text."""
        loose, dense, ratio = self.loose_ns, self.dense_ns, self.ratio
        lines = [
            f"{self.case}: {self.particles:,} particles, {self.per_cell:g} a cell and 8, "
            f"{self.threads} threads, median of {self.batches} pairs of batches of {self.steps} steps",
            f"  {loose.median:.1f} ns a particle and step ({loose.least:.1f}-{loose.largest:.1f}); "
            f"{dense.median:.1f} ns in dense snow ({dense.least:.1f}-{dense.largest:.1f})",
            f"  ratio {ratio.median:.2f} ({ratio.least:.2f}-{ratio.largest:.2f})",
        ]
        lines += [f"  {stage:6}{ns:+8.1f} ns" for stage, ns in self.growth_ns.items()]
        return "\n".join(lines)


def block() -> Scene:
    """Return the scene of a block of snow in free fall."""
    x, y, z = (n * DX for n in CELLS)
    return Scene(
        numerics=Numerics(dx=DX, dt=DT, initial_volume="sampled"),
        sources=(Source.of("box", center=(0.0, 0.0, 0.0), size=(x, y, z)),),
        camera=Camera(position=(2 * x, -4 * x, 2 * x), target=(0.0, 0.0, 0.0)),
    )


def scatter(sim: Simulation, per_cell: float, seed: int = 1) -> None:
    """Spread the particles at random over a cube that has room for `per_cell` of them in a cell."""
    x = sim.state.x
    side = DX * (len(x) / per_cell) ** (1 / 3)
    x[...] = np.random.default_rng(seed).uniform(-0.5 * side, 0.5 * side, x.shape).astype(x.dtype)


def measure_loose(per_cell: float = LOOSE, batches: int = BATCHES, steps: int = STEPS) -> Scattered:
    """Time batches of scattered snow and of the block that it came from, in turn."""
    dense, loose = Simulation(block()), Simulation(block())
    scatter(loose, per_cell)
    for sim in (dense, loose):
        sim.advance(WARM * DT)
    ns: list[tuple[float, float]] = []
    stages: list[dict[str, float]] = []
    for _ in range(batches):
        before, after = (_stages(sim, steps) for sim in (dense, loose))
        ns.append((sum(after.values()), sum(before.values())))
        stages.append({stage: after[stage] - before[stage] for stage in after})
    return Scattered(
        case="loose",
        particles=loose.count,
        threads=_core.threads(),
        steps=steps,
        batches=batches,
        per_cell=per_cell,
        loose_ns=Spread.of([a for a, _ in ns]),
        dense_ns=Spread.of([b for _, b in ns]),
        ratio=Spread.of([a / b for a, b in ns]),
        growth_ns={stage: float(np.median([one[stage] for one in stages])) for stage in stages[0]},
    )


def _stages(sim: Simulation, steps: int) -> dict[str, float]:
    """Advance by a batch; return the wall time of each stage per particle and step [ns]."""
    sim.advance(steps * DT)
    return {stage: 1e9 * s / (steps * sim.count) for stage, s in sim.stats.stage_seconds.items()}
