"""Measure what each transfer, spline, law and precision costs: a block, with one choice changed at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import process_time
from typing import Any

from neve import _core
from neve.bench.spread import Spread
from neve.scene.schema.material import Snow
from neve.scene.schema.scene import Scene
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS
from neve.simulation import Simulation

STEPS, BATCHES, WARM = 10, 9, 60
"""Steps of a batch, batches of each choice, steps before the first."""


@dataclass
class Costs:
    """Hold what a particle and step costs with each choice, from batches in turn.

    Attributes:
        case: name of the case
        particles, threads, steps, batches: sizes
        ns: processor time per particle and step, over all threads, by choice [ns]; the first are the defaults
    """

    case: str
    particles: int
    threads: int
    steps: int
    batches: int
    ns: dict[str, Spread]

    def text(self) -> str:
        """Return the result as lines of text."""
        usual = next(iter(self.ns.values())).least
        lines = [
            f"{self.case}: {self.particles:,} particles, {self.threads} threads, {self.batches} batches of "
            f"{self.steps} steps of each in turn; processor time, ns a particle and step, least and median"
        ]
        for choice, spread in self.ns.items():
            lines.append(
                f"  {choice:24}{spread.least:8.1f} {spread.median:8.1f}   {spread.least / usual:5.2f} times"
            )
        return "\n".join(lines)


def scenes(block: Callable[..., Scene]) -> dict[str, Scene]:
    """Return the scenes by choice, the defaults first; block: makes one from changes of [numerics]."""
    numerics: dict[str, dict[str, Any]] = {"defaults": {}}
    numerics |= {name: {"transfer": name} for name in list(TRANSFERS)[1:]}
    numerics["polypic, 27 modes"] = {"transfer": "polypic", "polypic_modes": 27}
    numerics |= {name: {"spline": name} for name in list(SPLINES)[1:]}
    numerics["float64"] = {"precision": "float64"}
    found = {name: block(**changes) for name, changes in numerics.items()}
    for law in list(LAWS)[1:]:
        found[law] = block().model_copy(update={"snow": Snow(law=law)})
    return found


def measure_choices(
    block: Callable[..., Scene], dt: float, batches: int = BATCHES, steps: int = STEPS, warm: int = WARM
) -> Costs:
    """Time batches of each choice in turn; `dt` is the scenes' time step [s]."""
    sims = {choice: Simulation(scene) for choice, scene in scenes(block).items()}
    for sim in sims.values():
        sim.advance(warm * dt)
    ns: dict[str, list[float]] = {choice: [] for choice in sims}
    for _ in range(batches):
        for choice, sim in sims.items():
            begun, before = process_time(), sim.steps
            sim.advance(steps * dt)
            ns[choice].append(1e9 * (process_time() - begun) / ((sim.steps - before) * sim.count))
    return Costs(
        case="choices",
        particles=next(iter(sims.values())).count,
        threads=_core.threads(),
        steps=steps,
        batches=batches,
        ns={choice: Spread.of(times) for choice, times in ns.items()},
    )
