"""A wall draws back slowly and leaves a slope of loose grains (known answer 23)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.validate.granular import G, plane_strain, restless, sliding, surface
from neve.validate.result import Check, Curve, Plot, Result, at_most, band
from neve.validate.scenes import box, plane, simulation, slab

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slope:
    """Hold a slope at rest: profile [m] and its angle [degrees]."""

    x: Array
    top: Array
    angle: float
    speed: float
    particles: int
    steps: int


def repose(degrees: float, cells: int = 16, pace: float = 0.2, threads: int = 1) -> Slope:
    """Draw back the wall before a heap of `cells` cells height by `pace` [m/s], and measure the slope."""
    height, length = 0.2, 0.36
    h = height / cells
    end = length + 1.2 * height / np.tan(np.radians(degrees))
    sim = simulation(
        [box((0, 0, 0), (length, h, height))],
        [
            *slab(h),
            plane((0, 0, 0), (1, 0, 0)),
            plane((0, 0, 0), (0, 0, 1), "sticky"),
            plane((length, 0, 0), (-1, 0, 0), "separate", velocity=[pace, 0.0, 0.0]),
        ],
        snow={"law": "drucker_prager", "rho0": 400.0, "E0": 1e5, "nu": 0.3, "friction_angle": degrees},
        gravity=(0.0, 0.0, -G),
        dx=h,
        precision="float32",
        sampling="jittered",
        threads=threads,
    )
    sim.advance(float((end - length) / pace))
    x, top = surface(sim, h)
    inside = (top < 0.75 * height) & (top > 0.2 * height)
    tilt = -np.polyfit(x[inside], top[inside], 1)[0]
    angle = float(np.degrees(np.arctan(tilt)))
    return Slope(x, top, angle, restless(sim), int(sim.state.count), sim.steps)


ANGLES = (20.0, 26.0, 30.0)


def case(threads: int = 1, angles: tuple[float, ...] = ANGLES, cells: int = 12) -> Result:
    """Measure the slopes that loose snow of several angles of friction leaves."""
    runs = {phi: repose(phi, cells, threads=threads) for phi in angles}
    checks = []
    for phi, r in runs.items():
        reason = "3&deg;: strips a cell wide, and a toe of single grains"
        checks.append(Check(f"slope, friction angle {phi:g}&deg;", r.angle, phi, 3.0, reason, "°"))
        bound = "no slope in plane strain can be steeper than arcsin(M / &radic;3)"
        checks.append(
            at_most(f"slope, friction angle {phi:g}&deg;, bound", r.angle, plane_strain(phi)[0], bound, "°")
        )
        checks.append(at_most(f"speed left, {phi:g}&deg;", r.speed, 0.02, "at rest", "m/s"))
    return Result(
        what="A heap of loose snow stands behind a smooth wall, which draws back at 0.2 m/s and leaves a "
        "slope. The slope is that of a line through the surface between a fifth and three quarters of the "
        "height; a slab one cell thick between smooth planes.",
        equations=(
            "slope = <i>&phi;</i>",
            "steady shear: tan <i>&theta;</i> = <i>M</i>/&radic;3, &nbsp; plane strain: sin <i>&phi;</i>* = "
            "<i>M</i>/&radic;3, &nbsp; <i>M</i> = 6 sin <i>&phi;</i>/(3 &minus; sin <i>&phi;</i>)",
        ),
        source="Coulomb's law of a heap; the two other angles of a Drucker-Prager cone are ours: it "
        "fits triaxial compression, and flow at constant volume in plane strain meets it elsewhere.",
        checks=tuple(checks),
        plots=_plots(runs),
        verdict="Heaps come to rest within 3&deg; of the angle of friction, below the slope on which the "
        "cone shears steadily.",
        remarks=(
            "Steeper laws leave heaps that are too flat: 29.1&deg; for 32&deg;, 30.4&deg; for 35&deg;. Finer "
            "grids and slower walls change that by less than 1&deg; (tried at 26&deg;).",
        ),
        particles=sum(r.particles for r in runs.values()),
        steps=sum(r.steps for r in runs.values()),
    )


def _plots(runs: dict[float, Slope]) -> tuple[Plot, ...]:
    x = np.array(list(runs))
    profiles = [Curve(f"{phi:g} degrees", r.x, r.top, "joined") for phi, r in runs.items()]
    return (
        Plot(
            "Slope that is left",
            "friction angle of the law [degrees]",
            "slope [degrees]",
            (
                band("slope = angle, 3 degrees", x, x, 3.0),
                Curve("steady shear of the cone", x, np.array([sliding(phi) for phi in runs]), "other"),
                Curve("measured", x, np.array([r.angle for r in runs.values()])),
            ),
        ),
        Plot("Slopes", "distance from the back [m]", "height [m]", tuple(profiles), equal=True),
    )
