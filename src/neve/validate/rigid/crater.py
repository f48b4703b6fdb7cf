"""A rigid ball falls on snow: how deep it goes, against its density and the height of its fall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.validate.grains.plane_strain import G
from neve.validate.result import Check, Curve, Plot, Result, at_least, at_most
from neve.validate.scenes import box, plane, simulation

Array = NDArray[np.float64]

RADIUS = 0.1
"""Of the ball [m]."""
HALF_WIDTH, LAYER = 0.4, 0.6
"""Half the width of the layer of snow, and its depth [m]."""
STOPPED = 0.02
"""A ball has stopped at this share of the speed with which it came [1]."""
LONGEST = 0.5
"""A ball that creeps on is not followed for longer [s]."""


@dataclass(frozen=True)
class Fall:
    """Hold a fall; energies are those of the whole ball.

    Attributes:
        depth: of the ball's lowest point below the surface, where it stops [m]
        way: H + depth, how far it fell in all [m]
        energy: m g (H + depth) [J]
        work: of the ball on the snow, from what they exchanged [J]
        left: kinetic energy of the ball at the end [J]
    """

    depth: float
    way: float
    energy: float
    work: float
    left: float
    particles: int
    steps: int

    @property
    def imbalance(self) -> float:
        """What the fall gave, less what the snow took and the ball kept, over what the fall gave [1]."""
        return 1.0 - (self.work + self.left) / self.energy


def fall(
    density: float,
    height: float,
    dx: float = 0.04,
    layer: float = LAYER,
    **numerics: Any,
) -> Fall:
    """Let a ball of `density` [kg/m3] fall from `height` [m] above the surface, until it stops.

    A quarter of the ball and of the snow between smooth planes x = 0 and y = 0, which carries a quarter of
    the mass; it can only move up and down. It starts at the surface with the speed sqrt(2 g H).
    """
    mass = density * np.pi * RADIUS**3 / 3  # of the quarter
    speed = float(np.sqrt(2 * G * height))
    sim = simulation(
        [box((0, 0, -layer), (HALF_WIDTH, HALF_WIDTH, 0))],
        [
            plane((0, 0, -layer), (0, 0, 1), "sticky"),
            plane((0, 0, 0), (1, 0, 0)),
            plane((0, 0, 0), (0, 1, 0)),
            plane((HALF_WIDTH, 0, 0), (-1, 0, 0)),
            plane((0, HALF_WIDTH, 0), (0, -1, 0)),
        ],
        bodies=[
            {
                "shape": "sphere",
                "radius": RADIUS,
                "center": [0.0, 0.0, RADIUS],
                "mass": float(mass),
                "velocity": [0.0, 0.0, -speed],
                "joint": "slide",
                "axis": [0.0, 0.0, 1.0],
                "contacts": False,
                "mu_c": 0.0,
            }
        ],
        gravity=(0.0, 0.0, -G),
        **{"precision": "float32", "dx": dx, **numerics},
    )
    ball = sim.solids()[-1][1]
    while -ball.velocity[2] > STOPPED * speed and sim.time < LONGEST:
        sim.advance(1e-3)
        ball = sim.solids()[-1][1]
    depth = float(RADIUS - ball.position[2])
    return Fall(
        depth=depth,
        way=height + depth,
        energy=float(4 * mass * G * (height + depth)),
        work=float(4 * sim.exchanged[-1, 6]),
        left=float(2 * mass * ball.velocity[2] ** 2),
        particles=int(sim.state.count),
        steps=sim.steps,
    )


Falls = dict[tuple[float, float], Fall]


def exponents(runs: Falls) -> tuple[float, float]:
    """Return a and b of depth ~ density^a way^b, by least squares of the logarithms [1]."""
    rows = np.array([(1.0, np.log(rho), np.log(run.way)) for (rho, _), run in runs.items()])
    found = np.linalg.lstsq(rows, np.log([run.depth for run in runs.values()]), rcond=None)[0]
    return float(found[1]), float(found[2])


def over_energy(runs: Falls) -> tuple[float, float, float]:
    """Return c, e of depth = c energy^e, and the largest factor by which a run is off that line."""
    x = np.log([run.energy for run in runs.values()])
    y = np.log([run.depth for run in runs.values()])
    e, c = np.polyfit(x, y, 1)
    return float(np.exp(c)), float(e), float(np.exp(np.abs(y - c - e * x).max()))


def growth(runs: Falls) -> tuple[float, float]:
    """Return the least factor of depth from one density to the next, and from one height to the next."""
    densities, heights = sorted({rho for rho, _ in runs}), sorted({H for _, H in runs})
    d = np.array([[runs[rho, H].depth for H in heights] for rho in densities])
    return float((d[1:] / d[:-1]).min()), float((d[:, 1:] / d[:, :-1]).min())


DENSITIES = (200.0, 600.0, 2000.0, 7800.0)
HEIGHTS = (0.1, 0.3, 1.0)
FINE = 0.025
"""Cells of the run that is repeated [m]."""


def case(
    densities: tuple[float, ...] = DENSITIES, heights: tuple[float, ...] = HEIGHTS, refine: bool = True
) -> Result:
    """Measure depths over densities and heights, and repeat one with finer cells if `refine`."""
    runs = {(rho, H): fall(rho, H) for rho in densities for H in heights}
    middle = (densities[len(densities) // 2], heights[len(heights) // 2])
    fine = fall(*middle, dx=FINE) if refine else None
    a, b = exponents(runs)
    everything = [*runs.values(), *([fine] if fine else [])]
    return Result(
        what=f"A rigid, smooth ball of {2 * RADIUS:g} m falls on a layer of default snow, {LAYER:g} m deep, "
        "and stops. The depth is that of its lowest point below the surface. A quarter of both, between "
        "smooth planes; the ball moves up and down only, and gives way to the snow as any body of a scene "
        "does. Cells of 0.04 m, five across the ball.",
        equations=(
            "<i>m g</i> (<i>H</i> + <i>d</i>) = work of the ball on the snow",
            "<i>d</i> &prop; <i>E</i><sup>1/2</sup>, &nbsp; <i>E</i> = <i>mg</i>(<i>H</i> + <i>d</i>), "
            "&nbsp; in snow of constant strength: <i>E</i> = <i>p&pi;d</i><sup>2</sup>(<i>R</i> &minus; "
            "<i>d</i>/3)",
        ),
        source="Energy of the ball; the volume of a cap, for d up to R. Of loose grains, which snow is not, "
        "<i>d</i> &prop; <i>&rho;</i><sup>1/2</sup> <i>H</i><sup>1/3</sup> was measured (Uehara, Ambroso, "
        "Ojha and Durian 2003; read in the abstract): drawn beside, not checked.",
        checks=_checks(runs, (middle, fine) if fine else None),
        plots=_plots(runs),
        verdict="Denser balls and higher falls make deeper craters, and the exchange totals contain what the "
        f"fall gave: <i>d</i> &prop; <i>&rho;</i><sup>{a:.2f}</sup> (<i>H</i> + <i>d</i>)<sup>{b:.2f}</sup>.",
        particles=sum(run.particles for run in everything),
        steps=sum(run.steps for run in everything),
        remarks=(
            "Default snow is soft and weak (see the case against real snow), so these are not the depths of "
            "a real snow cover.",
        ),
    )


def _checks(runs: Falls, again: tuple[tuple[float, float], Fall] | None) -> tuple[Check, ...]:
    by_density, by_height = growth(runs)
    _, exponent, off = over_energy(runs)
    checks = [
        at_most(
            "largest share of the energy of the fall that the exchange totals miss",
            max(abs(run.imbalance) for run in runs.values()),
            0.025,
            "work is computed with the velocity after a step, half of the step's change too small: 1 / (2 n) "
            "and more in n steps, of which the lightest ball needs 60",
        ),
        at_least("least factor of depth to the next density", by_density, 1.0, "denser is deeper"),
        at_least("least factor of depth to the next height", by_height, 1.0, "higher is deeper"),
        at_most(
            "exponent of the depth over the energy",
            exponent,
            0.5,
            "1/2 for a shallow cap in snow of constant strength; snow hardens while it is pressed",
        ),
        at_most(
            "largest factor off one line over the energy",
            off,
            1.25,
            "our own mark: energy alone decides, but for the inertia of the snow",
        ),
    ]
    if again:
        place, fine = again
        name = f"depth of {place[0]:g} kg/m3 from {place[1]:g} m, finer cells over these"
        checks.append(Check(name, fine.depth / runs[place].depth, 1.0, 0.05, "an eighth of a cell"))
    return tuple(checks)


def _plots(runs: Falls) -> tuple[Plot, ...]:
    densities, heights = sorted({rho for rho, _ in runs}), sorted({H for _, H in runs})
    rho, last = np.array(densities), heights[-1]
    depths = {H: np.array([runs[r, H].depth for r in densities]) for H in heights}
    c, e, _ = over_energy(runs)
    energy = np.array(sorted(run.energy for run in runs.values()))
    grains = 1.25 * depths[last][0] * np.sqrt(rho / rho[0])
    return (
        Plot(
            "Depth over density",
            "density of the ball [kg/m3]",
            "depth [m]",
            (
                *(Curve(f"from {H:g} m", rho, depths[H], "joined") for H in heights),
                Curve("slope 1/2, loose grains", rho, grains, "other"),
            ),
            "log",
            "log",
        ),
        Plot(
            "Depth over energy",
            "energy of the fall [J]",
            "depth [m]",
            (
                *(
                    Curve(f"{r:g} kg/m3", np.array([runs[r, H].energy for H in heights]), d)
                    for r, d in ((r, np.array([runs[r, H].depth for H in heights])) for r in densities)
                ),
                Curve(f"slope {e:.2f}", energy, c * energy**e, "other"),
            ),
            "log",
            "log",
        ),
    )
