"""A column of loose grains collapses and runs out (known answer 22)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.validate.grains.plane_strain import G, front, restless, sliding, surface
from neve.validate.result import Curve, Plot, Result, at_most, band, near
from neve.validate.scenes import box, plane, simulation, slab

Array = NDArray[np.float64]

PHI = 26.0
WIDTH = 0.2
SNOW = {"law": "drucker_prager", "rho0": 400.0, "E0": 1e5, "nu": 0.3, "friction_angle": PHI}


@dataclass(frozen=True)
class Deposit:
    """Hold what a collapse leaves: aspect, run-out over width [1], profile [m], speed [m/s]."""

    aspect: float
    runout: float
    x: Array
    top: Array
    speed: float
    particles: int
    steps: int


def collapse(aspect: float, cells: int = 16) -> Deposit:
    """Let go a column `aspect` times as high as wide, behind a smooth wall, on a rough ground."""
    h, height = WIDTH / cells, aspect * WIDTH
    sim = simulation(
        [box((0, 0, 0), (WIDTH, h, height))],
        [*slab(h), plane((0, 0, 0), (1, 0, 0)), plane((0, 0, 0), (0, 0, 1), "sticky")],
        snow=SNOW,
        gravity=(0.0, 0.0, -G),
        dx=h,
        precision="float32",
        sampling="jittered",
    )
    sim.advance(4.5 * float(np.sqrt(height / G)) + 0.2)
    x, top = surface(sim, h)
    runout = front(sim, h) / WIDTH - 1
    return Deposit(aspect, runout, x, top, restless(sim), int(sim.state.count), sim.steps)


ASPECTS = (1.0, 1.5, 2.0, 3.0)


def answer(aspect: float) -> float:
    """Return the run-out over the width [1]: 1.2 a up to a = 2.3, then 1.9 a^(2/3) [M]."""
    return float(1.2 * aspect if aspect < 2.3 else 1.9 * aspect ** (2 / 3))


def case(aspects: tuple[float, ...] = ASPECTS, cells: int = 16) -> Result:
    """Measure the run-out of columns of several aspects."""
    runs = [collapse(aspect, cells) for aspect in aspects]
    reason = "20 %, the scatter between laboratories, beds and grains"
    checks = [
        near(f"run-out over width, height {r.aspect:g} widths", r.runout, answer(r.aspect), 0.2, reason)
        for r in runs
    ]
    still = max(r.speed for r in runs)
    checks.append(at_most("speed at the end", still, 0.02, "a hundredth of the fall's", "m/s"))
    return Result(
        what=f"A column of loose grains, {cells} cells wide and one thick between smooth planes, stands at a "
        "smooth wall on a rough ground and is let go. The run-out is how far the heap reaches beyond the "
        "column's foot.",
        equations=(
            "&Delta;<i>L</i>/<i>L</i><sub>0</sub> = 1.2 <i>a</i> for <i>a</i> &lt; 2.3, then 1.9 "
            "<i>a</i><sup>2/3</sup>; <i>a</i> = <i>H</i>/<i>L</i><sub>0</sub>",
        ),
        source="Experiments with dry grains in a channel: Lube et al. 2004, Lajeunesse et al. 2005 [M: "
        "quoted from memory, not checked against the papers].",
        checks=tuple(checks),
        plots=_plots(runs),
        verdict=f"Loose snow with an angle of {PHI:g}&deg; (slope in steady shear {sliding(PHI):.1f}&deg;) "
        "runs out as far as dry grains do.",
        remarks=(
            "The law holds over grains and beds to 20 % only, and cannot distinguish angles of friction. The "
            "front is thinner than a cell: finer grids run out further, by 8 to 11 % from 12 to 16 cells.",
        ),
        particles=sum(r.particles for r in runs),
        steps=sum(r.steps for r in runs),
    )


def _plots(runs: list[Deposit]) -> tuple[Plot, ...]:
    aspects = np.array([r.aspect for r in runs])
    a = np.linspace(0.8 * aspects.min(), 1.1 * aspects.max(), 100)
    law = np.array([answer(each) for each in a])
    return (
        Plot(
            "Run-out",
            "height over width of the column, a [1]",
            "run-out over width [1]",
            (
                band("experiments [M], 20 %", a, law, 0.2 * law),
                Curve("measured", aspects, np.array([r.runout for r in runs])),
            ),
        ),
        Plot(
            "Heaps",
            "distance from the wall [m]",
            "height [m]",
            tuple(Curve(f"a = {r.aspect:g}", r.x, r.top, "joined") for r in runs),
            equal=True,
        ),
    )
