"""Run a coarse likeness of a scene, to foresee the steps of the scene itself.

Waves and snow cross a cell of the size dx in a time in proportion to dx, and so do all bounds of the
automatic step but numerics.dt_max. A likeness with k dx, k numerics.dt and k numerics.dt_max therefore takes,
at any time, steps k times as long as the scene does, at 1/k^4 of its cost, as long as both move alike.
"""

from __future__ import annotations

import logging
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from neve.sampling.fineness import particles_of
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.values.fields import SHORTEST
from neve.solver import Blowup

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene
    from neve.simulation import Simulation

LEAST_COARSER = 1.2
"""Factor on dx below which a likeness is not worth its time: the scene itself is tried then."""
FEWEST = 100
"""Particles with which a likeness is still alike."""
SLOWEST = 2.0
"""Factor on the time of a step that the scattering of snow is believed to make."""


@dataclass(frozen=True)
class Trial:
    """Hold what a likeness did.

    Attributes:
        coarser: its dx over that of the scene [1]
        particles: how many it had
        times: when each of its steps ended [s], (k,)
        dt: of the scene at these times [s], (k,)
        growth: largest memory of its state and grid over that of its first step [1]
        seconds_per_work: wall time for each step and particle [s]
        covered: share of the duration that it ran for [1]
        slower: wall time of its mean step over that of its first ones [1]
        counts: particles after each of its steps, (k,)
    """

    coarser: float
    particles: int
    times: NDArray[np.float64]
    dt: NDArray[np.float64]
    growth: float
    seconds_per_work: float
    covered: float
    slower: float
    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def steps(self, frames: int, fps: int) -> int:
        """Return how many steps the scene takes for `frames`, each of which is a whole number of steps.

        Where the trial has not been, steps are as long as in the last third of where it has.
        """
        ends = np.arange(1, frames + 1) / fps
        begins = np.concatenate([[0.0], self.times[:-1]])
        done = np.concatenate([[0.0], np.cumsum((self.times - begins) / self.dt)])
        count = np.interp(ends, np.concatenate([[0.0], self.times]), done)
        late = slice(2 * len(self.dt) // 3, None)
        pace = (done[-1] - done[:-1][late][0]) / (self.times[-1] - begins[late][0])
        count = np.where(ends > self.times[-1], done[-1] + (ends - self.times[-1]) * pace, count)
        each = np.diff(np.concatenate([[0.0], count]))
        return int(np.maximum(np.ceil(each - 1e-6), 1.0).sum())


def trial(scene: Scene, coarser: float, duration: float, seconds: float, threads: int | None) -> Trial | None:
    """Run a likeness of `scene`, of `coarser` times its dx, for `duration` [s] or so many `seconds` at most.

    A source that would be too small is met by a finer likeness. None if there is none that can be run.
    """
    while True:
        coarser = coarser if coarser >= LEAST_COARSER else 1.0
        try:
            with silence():
                return _run(likeness(scene, coarser), coarser, duration, seconds, threads)
        except (SceneError, Blowup, ValueError):
            if coarser == 1.0:
                return None
        coarser *= 0.7


def likeness(scene: Scene, coarser: float) -> Scene:
    """Return the scene with `coarser` times its dx, and its given times of steps as much longer."""
    old = scene.numerics
    new = {"dx": old.dx * coarser, "dt_max": min(max(old.dt_max * coarser, SHORTEST), 1.0)}
    if old.dt != "auto":
        new["dt"] = old.dt * coarser
    return scene.model_copy(update={"numerics": old.model_copy(update=new)})


@contextmanager
def silence() -> Iterator[None]:
    """Keep what a trial warns of from the user: the run itself says it."""
    logger = logging.getLogger("neve")
    before = logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            yield
    finally:
        logger.disabled = before


def _run(scene: Scene, coarser: float, duration: float, seconds: float, threads: int | None) -> Trial:
    from neve.simulation import Simulation

    sim = Simulation(scene, threads=threads)
    there = particles_of(scene) if scene.emitters else sim.count
    if there < FEWEST and coarser > 1.0:
        raise SceneError(f"{there:.0f} particles are too few to tell of more")
    times: list[float] = []
    walls: list[float] = []
    sizes: list[int] = []
    counts: list[int] = []
    begin = time.monotonic()

    def enough() -> bool:
        times.append(sim.time)
        walls.append(time.monotonic() - begin)
        sizes.append(sim.bytes)
        counts.append(sim.count)
        return walls[-1] > seconds

    try:
        sim.advance(duration, enough)
    except Blowup:
        if len(times) < 3:
            raise
    ends, each = np.array(times), np.diff(walls)
    early = float(np.median(each[: max(len(each) // 20, 5)])) if len(each) else 0.0
    return Trial(
        coarser=coarser,
        particles=sim.count,
        times=ends,
        dt=np.diff(ends, prepend=0.0) / coarser,
        growth=max(sizes) / max(sizes[0], 1),
        seconds_per_work=walls[-1] / max(sum(counts), 1),
        covered=min(float(ends[-1]) / duration, 1.0),
        slower=min(max(float(np.mean(each)) / early, 1.0), SLOWEST) if early > 0 else 1.0,
        counts=np.array(counts),
    )


def pace(sim: Simulation, seconds: float) -> float:
    """Return the wall time of a step of `sim` [s], from as many steps as fit into `seconds`, at least two.

    The first step is left out: it also makes ready what the others find.
    """
    marks: list[float] = []

    def enough() -> bool:
        marks.append(time.monotonic())
        return len(marks) > 2 and marks[-1] - marks[0] > seconds

    with silence():
        sim.advance(sim.scene.run.duration, enough)
    return (marks[-1] - marks[0]) / (len(marks) - 1) if len(marks) > 1 else 0.0
