"""A block slides down a slope as Coulomb says, and its energy line falls by the friction (19, 21)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.simulation import Simulation
from neve.validate.elastic.settlement import relax
from neve.validate.result import Check, Curve, Plot, Result, band
from neve.validate.scenes import column, elastic, plane, simulation

Array = NDArray[np.float64]

G = 9.81
SIZE = (0.4, 0.4, 0.2)
"""Of the block along the slope, across and off it [m]."""


@dataclass(frozen=True)
class Slide:
    """Hold a slide over time t [s]: way [m], speed [m/s] and height [m] of the centre of mass.

    bounce: the centre's speed off the plane [m/s]
    """

    t: Array
    way: Array
    speed: Array
    height: Array
    bounce: Array
    particles: int
    steps: int

    def acceleration(self, mu_c: float = 0.0) -> float:
        """Return the slope of the speed over the second half, by least squares [m/s2], without bouncing.

        A block that bounces off by v_n has had m v_n too much from the plane, and friction took mu_c of it
        while the block slid: speed + mu_c v_n grows as if the block never bounced. One that sticks has
        mu_c = 0 here, since its friction is no share of the normal force.
        """
        half = len(self.t) // 2
        return float(np.polyfit(self.t[half:], (self.speed + mu_c * self.bounce)[half:], 1)[0])

    def energy_line(self, degrees: float) -> tuple[Array, Array]:
        """Return the horizontal way and the energy head z + v^2 / 2 g, both from the start [m]."""
        head = self.height + self.speed**2 / (2 * G)
        return self.way * np.cos(np.radians(degrees)), head - head[0]


def slide(
    degrees: float,
    mu_c: float,
    dx: float = 0.05,
    seconds: float = 0.6,
    frames: int = 30,
    rho0: float = 400.0,
    mode: str = "separate",
    **numerics: Any,
) -> Slide:
    """Put an elastic block on a plane tilted against the grid by `degrees`, let it settle, and let go.

    It settles on a plane that it cannot slide on, so that it does not bounce when the slide begins.
    """
    theta = np.radians(degrees)
    normal = np.array([np.sin(theta), 0.0, np.cos(theta)])
    down = np.array([np.cos(theta), 0.0, -np.sin(theta)])
    block = {
        "shape": "box",
        "size": list(SIZE),
        "center": (0.5 * SIZE[2] * normal).tolist(),
        "rotation": [0.0, float(degrees), 0.0],
    }
    held, free = (
        simulation(
            [block],
            [plane((0, 0, 0), normal, mode, mu_c=friction)],
            snow=elastic(rho0=rho0),
            gravity=(0.0, 0.0, -G),
            dx=dx,
            **numerics,
        )
        for friction in (100.0, mu_c)
    )
    relax(held, 0.2, 2e-3)
    sim = Simulation.restore(free.scene, held.arrays(), 1)
    begun = sim.time
    rows = []
    for frame in range(frames + 1):
        if frame:
            sim.advance(seconds / frames)
        m, x, v = column(sim, "m"), column(sim, "x"), column(sim, "v")
        rows.append((sim.time - begun, *(m @ a / m.sum() for a in (x @ down, v @ down, x[:, 2], v @ normal))))
    t, way, speed, height, bounce = np.array(rows).T
    return Slide(t, way - way[0], speed, height, bounce, int(sim.state.count), sim.steps)


ANGLES = (10, 20, 30, 40)
FRICTIONS = (0.0, 0.3, 0.5)
Runs = dict[tuple[int, float], Slide]


def answer(degrees: Array | float, mu_c: float) -> Array:
    """Return the acceleration down the slope [m/s2]: 0 if tan theta <= mu_c, else g (sin - mu_c cos)."""
    theta = np.radians(degrees)
    return np.asarray(G * np.maximum(np.sin(theta) - mu_c * np.cos(theta), 0.0))


def case(angles: tuple[int, ...] = ANGLES, frictions: tuple[float, ...] = FRICTIONS) -> Result:
    """Measure the acceleration over angles and frictions, and the slope of the energy line."""
    runs = {(d, mu): slide(d, mu) for mu in frictions for d in angles}
    return Result(
        what="A block of elastic snow lies on a plane that is tilted against the grid, and is let go. "
        "Coulomb's "
        "friction acts at the plane alone. The energy line is the head of energy over the horizontal way.",
        equations=(
            "<i>a</i> = 0 if tan <i>&theta;</i> &le; <i>&mu;</i>, else <i>g</i>(sin <i>&theta;</i> &minus; "
            "<i>&mu;</i> cos <i>&theta;</i>)",
            "d(<i>z</i> + <i>v</i><sup>2</sup>/2<i>g</i>)/d<i>x</i> = &minus;<i>&mu;</i>",
        ),
        source="Coulomb's law of friction; the energy line of avalanche practice. Neve has no Voellmy "
        "friction, "
        "so its terminal speed (number 20) does not apply.",
        checks=_checks(runs),
        plots=_plots(runs),
        verdict="Snow sticks and slides as Coulomb says, on a plane that lies across the grid.",
        particles=sum(r.particles for r in runs.values()),
        steps=sum(r.steps for r in runs.values()),
    )


def _pull(degrees: float) -> float:
    """Return g sin theta [m/s2]."""
    return float(G * np.sin(np.radians(degrees)))


def _checks(runs: Runs) -> tuple[Check, ...]:
    checks = []
    for (d, mu), r in runs.items():
        name, exact = f"acceleration at {d}&deg;, friction {mu:g}", float(answer(d, mu))
        if exact > 0:
            reason = "1 % of the acceleration; what bouncing adds to the friction is taken out"
            checks.append(Check(name, r.acceleration(mu), exact, 0.01 * exact, reason, "m/s2"))
        else:
            reason = "1 % of g sin(theta), the pull that friction holds"
            checks.append(Check(name, r.acceleration(), 0.0, 0.01 * _pull(d), reason, "m/s2"))
    steep = max(d for d, _ in runs)
    for (d, mu), r in runs.items():
        if d == steep:
            x, head = r.energy_line(d)
            half = len(x) // 2
            slope = float(np.polyfit(x[half:], head[half:], 1)[0])
            reason = "required of Neve: 1 to 2 %; speed and place of a step are half a step apart"
            checks.append(Check(f"slope of the energy line, friction {mu:g}", slope, -mu, 0.01, reason))
    return tuple(checks)


def _plots(runs: Runs) -> tuple[Plot, ...]:
    angles, frictions = sorted({d for d, _ in runs}), sorted({mu for _, mu in runs})
    steep, lines = max(angles), []
    fine = np.linspace(min(angles) - 5, max(angles) + 5, 200)
    for mu in frictions:
        x, head = runs[steep, mu].energy_line(steep)
        lines += [Curve(f"friction {mu:g}", x, head), Curve("", x, -mu * x, "exact")]
    exact = [
        band(
            "exact, 1 %" if mu == frictions[0] else "",
            fine,
            answer(fine, mu),
            0.01 * answer(fine, mu),
        )
        for mu in frictions
    ]
    measured = [
        Curve(
            f"friction {mu:g}",
            np.array(angles, float),
            np.array([runs[d, mu].acceleration(mu if answer(d, mu) > 0 else 0.0) for d in angles]),
        )
        for mu in frictions
    ]
    return (
        Plot("Acceleration", "slope [degrees]", "acceleration [m/s2]", (*exact, *measured)),
        Plot(f"Energy line at {steep} degrees", "horizontal way [m]", "energy head [m]", tuple(lines)),
    )
