"""Particles in contact: a block slides as Coulomb says, and heaps rest steeper than their friction."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from neve.validate.grains.repose import Slope, repose
from neve.validate.grains.slide import Slide, answer, slide
from neve.validate.result import Check, Curve, Plot, Result, at_least, at_most, near
from neve.validate.scenes import Table

Array = NDArray[np.float64]

METHOD: Table = {"method": "particles"}

SLIDES = ((35.0, 0.5), (30.0, 0.3))
STAYS = (20.0, 0.5)
"""Slopes [degrees] and frictions of blocks."""

HEAPS = (20.0, 30.0)
"""Friction angles of heaps [degrees]."""


def flattest(degrees: float) -> float:
    """Return the friction angle of grains that slide without rolling and keep their volume [degrees].

    tan phi = pi/2 tan phi_mu, with phi_mu = `degrees` between two grains: Caquot 1934, from memory.
    """
    return math.degrees(math.atan(0.5 * math.pi * math.tan(math.radians(degrees))))


def steepest(degrees: float) -> float:
    """Return the largest friction angle of such grains, where they lie as densely as they can [degrees].

    (1 + sin phi) / (1 - sin phi) = D tan(45 deg + phi_cv / 2)^2, where D is 1 at constant volume and at most
    2, phi_cv that of `flattest`: stress and dilatancy in plane strain, Rowe 1962, from memory.
    """
    ratio = 2.0 * math.tan(math.radians(45.0 + 0.5 * flattest(degrees))) ** 2
    return math.degrees(math.asin((ratio - 1.0) / (ratio + 1.0)))


def heap(degrees: float, cells: int = 10) -> Slope:
    """Draw back the wall before a heap of loose particles whose friction is tan(`degrees`)."""
    return repose(degrees, cells, thick=2, **METHOD)


def case(cells: int = 10) -> Result:
    """Let blocks of bonded particles slide and stay, and measure the slopes of loose heaps."""
    slides = {(a, mu): slide(a, mu, **METHOD) for a, mu in SLIDES}
    stays = slide(*STAYS, seconds=1.5, frames=75, **METHOD)
    heaps = {phi: heap(phi, cells) for phi in HEAPS}
    every: tuple[Slide | Slope, ...] = (*slides.values(), stays, *heaps.values())
    return Result(
        what="Snow as particles in contact (<i>numerics.method</i> = particles). An elastic block settles on "
        "a tilted plane that holds it, and is let go; bouncing is taken out of its speed. A heap of loose "
        "particles, two cells thick between smooth planes, stands behind a smooth wall that draws back at "
        "0.2 m/s and leaves a slope.",
        equations=(
            "<i>a</i> = <i>g</i> (sin <i>&theta;</i> &minus; <i>&mu;</i> cos <i>&theta;</i>), or rest",
            "tan <i>&phi;</i><sub>cv</sub> = <i>&pi;</i>/2 tan <i>&phi;<sub>&mu;</sub></i>, "
            "(1 + sin <i>&phi;</i>) / (1 &minus; sin <i>&phi;</i>) &le; "
            "2 tan<sup>2</sup>(45&deg; + <i>&phi;</i><sub>cv</sub> / 2)",
        ),
        source="Coulomb. Bounds of the slopes: grains that slide and do not roll (Caquot 1934), and stress "
        "and dilatancy (Rowe 1962), both from memory.",
        checks=_checks(slides, stays, heaps),
        plots=_plots(slides, stays, heaps),
        verdict="Blocks slide as Coulomb says. Heaps rest 15 to 22&deg; steeper than the angle of friction "
        "between their particles.",
        remarks=(
            "Why: particles do not roll, so grains of a heap leave their places only by sliding over each "
            "other, and the heap is held by their shapes as well as by friction. To get heaps of a given "
            "slope, find the friction by trial.",
            "A block that friction holds at 20&deg; may slip some centimetres while it still bounces from "
            "being let go, since little damps it, and then stays.",
        ),
        particles=sum(r.particles for r in every),
        steps=sum(r.steps for r in every),
    )


def _checks(
    slides: dict[tuple[float, float], Slide], stays: Slide, heaps: dict[float, Slope]
) -> tuple[Check, ...]:
    checks = [
        near(f"acceleration at {a:g}&deg;, friction {mu:g}", r.acceleration(mu), float(answer(a, mu)), 0.01,
             "1 %, as of the material point method", "m/s²")
        for (a, mu), r in slides.items()
    ]  # fmt: skip
    end = float(np.abs(stays.speed[-15:]).max())
    checks.append(
        at_most(f"speed at {STAYS[0]:g}&deg;, friction {STAYS[1]:g}, at the end", end, 0.01, "at rest", "m/s")
    )
    for phi, r in heaps.items():
        name = f"slope of a heap, friction angle {phi:g}&deg;"
        checks.append(at_least(name, r.angle, flattest(phi), "sliding at constant volume, no rolling", "°"))
        checks.append(at_most(name, r.angle, steepest(phi), "the densest packing, D = 2", "°"))
        checks.append(at_most(f"speed left, {phi:g}&deg;", r.speed, 0.02, "at rest", "m/s"))
    return tuple(checks)


def _plots(
    slides: dict[tuple[float, float], Slide], stays: Slide, heaps: dict[float, Slope]
) -> tuple[Plot, ...]:
    curves = []
    for (a, mu), r in slides.items():
        curves.append(Curve(f"{a:g} degrees, friction {mu:g}", r.t, r.speed, "joined"))
        curves.append(Curve("", r.t, r.speed[0] + float(answer(a, mu)) * r.t, "exact"))
    curves.append(Curve(f"{STAYS[0]:g} degrees, friction {STAYS[1]:g}", stays.t, stays.speed, "joined"))
    profiles = tuple(Curve(f"{phi:g} degrees", r.x, r.top, "joined") for phi, r in heaps.items())
    return (
        Plot("Speed of the blocks", "time [s]", "speed down the slope [m/s]", tuple(curves)),
        Plot("Slopes", "distance from the back [m]", "height [m]", profiles, equal=True),
    )
