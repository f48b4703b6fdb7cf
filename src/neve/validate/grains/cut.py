"""A vertical cut in cohesive snow stands or falls (known answer 24)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.simulation import Simulation
from neve.validate.elastic.settlement import relax
from neve.validate.grains.plane_strain import G, plane_strain
from neve.validate.result import Curve, Plot, Result, at_least, at_most
from neve.validate.scenes import box, column, plane, simulation, slab

Array = NDArray[np.float64]

PHI, RHO, HEIGHT = 20.0, 400.0, 0.4


def critical_height(cohesion: float) -> float:
    """Return H_c = 4 c* / (rho g) tan(45 + phi* / 2) [m], with the angle and cohesion of plane strain."""
    angle, c = plane_strain(PHI, cohesion)
    return float(4 * c / (RHO * G) * np.tan(np.radians(45 + angle / 2)))


@dataclass(frozen=True)
class Cut:
    """Hold a cut: times [s], settlement of the crest's edge over the height [1], particles [m]."""

    t: Array
    drop: Array
    x: Array
    particles: int
    steps: int


def cut(share: float, cells: int = 16, seconds: float = 0.5) -> Cut:
    """Let a cut stand whose height is `share` of the critical one.

    It comes to rest as elastic snow first; then it may yield.
    """
    h = HEIGHT / cells
    cohesion = HEIGHT / share / critical_height(1.0)
    common = {"rho0": RHO, "E0": 1e5, "nu": 0.3}
    held, free = (
        simulation(
            [box((0, 0, 0), (2 * HEIGHT, h, HEIGHT))],
            [*slab(h), plane((0, 0, 0), (1, 0, 0)), plane((0, 0, 0), (0, 0, 1), "sticky")],
            snow=common | snow,
            gravity=(0.0, 0.0, -G),
            dx=h,
        )
        for snow in (
            {"law": "hencky", "plasticity": "none"},
            {"law": "drucker_prager", "friction_angle": PHI, "cohesion": cohesion},
        )
    )
    relax(held, 0.5, 4e-3)
    sim = Simulation.restore(free.scene, held.arrays(), 1)
    start = column(sim, "x")
    crest = (start[:, 0] > 1.9 * HEIGHT) & (start[:, 2] > 0.9 * HEIGHT)
    rows = []
    begun = sim.time
    for _ in range(25):
        sim.advance(seconds / 25)
        rows.append((sim.time - begun, (start - column(sim, "x"))[crest, 2].mean() / HEIGHT))
    t, drop = np.array(rows).T
    return Cut(t, drop, column(sim, "x"), int(sim.state.count), sim.steps)


SHARES = (0.6, 0.8, 1.0, 1.3, 1.6)
STANDS, FALLS = 0.01, 0.1
"""Settlement of the crest over the height of a cut that stands, and of one that falls [1]."""


def case(shares: tuple[float, ...] = SHARES, cells: int = 12) -> Result:
    """Let cuts stand or fall on both sides of the critical height."""
    runs = {share: cut(share, cells) for share in shares}
    checks = []
    for share, r in runs.items():
        name = f"settlement of the crest over the height, {share:g} critical heights"
        if share <= 0.8:
            reason = "it stands: this is the first yielding at the foot"
            checks.append(at_most(name, r.drop[-1], STANDS, reason))
        if share >= 1.3:
            checks.append(at_least(name, r.drop[-1], FALLS, "it falls, and is still falling"))
    fallen = runs[max(shares)].x
    return Result(
        what="A block of cohesive snow with a vertical face comes to rest under gravity as elastic snow, and "
        "is then given its cohesion. The critical height is that of the friction angle and the cohesion that "
        "the cone has in plane strain. A slab one cell thick between smooth planes, on a rough ground.",
        equations=(
            "<i>H</i><sub>c</sub> = (4<i>c</i>*/<i>&rho;g</i>) tan(45&deg; + <i>&phi;</i>*/2)",
            "sin <i>&phi;</i>* = <i>M</i>/&radic;3, &nbsp; <i>c</i>* = <i>c</i> tan <i>&phi;</i>*/tan "
            "<i>&phi;</i>",
        ),
        source="Wedge of Coulomb and Rankine; stands below 0.8 and falls above 1.3 of the critical height, "
        "since slip lines need not be straight.",
        checks=tuple(checks),
        plots=(
            Plot(
                "Crest",
                "time [s]",
                "settlement of the crest over the height [1]",
                tuple(
                    Curve(f"{share:g} of the critical height", r.t, r.drop, "joined")
                    for share, r in runs.items()
                ),
            ),
            Plot(
                f"{max(shares):g} critical heights, half a second later",
                "distance [m]",
                "height [m]",
                (Curve("", fallen[:, 0], fallen[:, 2], "dots"),),
                equal=True,
            ),
        ),
        verdict="A cut in cohesive snow stands below its critical height and falls above it.",
        particles=sum(r.particles for r in runs.values()),
        steps=sum(r.steps for r in runs.values()),
    )
