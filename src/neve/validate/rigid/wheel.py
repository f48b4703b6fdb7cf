"""A rigid wheel drives over snow: how deep it sinks and how much it slips, next to plates pressed into it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.validate.grains.plane_strain import G
from neve.validate.result import Check, Curve, Plot, Result, at_least, at_most
from neve.validate.scenes import box, plane, simulation, slab

Array = NDArray[np.float64]

DX = 0.04
"""Cells of all runs, and the width of the slab of snow [m]."""
LAYER, RADIUS, SPEED = 0.4, 0.3, 1.2
"""Depth of the snow [m], radius of the wheel [m], speed of its rim [m/s]."""
START, SECONDS, STEADY = 0.35, 1.0, 0.5
"""Place of the axle at the start [m]; length of a run, and from when on it counts [s]."""
RAMP = 0.3
"""In this while a wheel gets its load and what it has to pull [s]."""
BARE = 0.2
"""Share of the load that is the wheel's own weight; the rest is a force, so that little mass bounces."""
PLATE_SPEED, PLATE_WAY = 0.3, 0.12
"""How fast and how far plates are pressed in [m/s, m]."""


def ground(length: float, dx: float) -> list[dict[str, Any]]:
    """Return the walls of a slab of snow one cell thick, `length` [m] long, on a rough floor."""
    return [
        *slab(dx),
        plane((0, 0, -LAYER), (0, 0, 1), "sticky"),
        plane((0, 0, 0), (1, 0, 0)),
        plane((length, 0, 0), (-1, 0, 0)),
    ]


@dataclass(frozen=True)
class Press:
    """Hold a plate's way into the snow: width [m], sinkage [m] and pressure [Pa]."""

    width: float
    sinkage: Array
    pressure: Array
    particles: int
    steps: int


def press(width: float, dx: float = DX, length: float = 1.6, looks: int = 24) -> Press:
    """Press a plate of `width` [m] into the snow, plane strain; the pressure is the mean between looks."""
    plate = {
        "shape": "box",
        "center": [0.5 * length, 0.5 * dx, 0.1],
        "size": [width, 4 * dx, 0.2],
        "velocity": [0.0, 0.0, -PLATE_SPEED],
    }
    sim = simulation(
        [box((0, 0, -LAYER), (length, dx, 0))],
        [*ground(length, dx), plate],
        gravity=(0.0, 0.0, -G),
        precision="float32",
        dx=dx,
    )
    pause = PLATE_WAY / PLATE_SPEED / looks
    impulse = [0.0]
    for _ in range(looks):
        sim.advance(pause)
        impulse.append(float(sim.exchanged[-1, 2]))
    sinkage = np.asarray(PLATE_SPEED * pause * (np.arange(looks) + 0.5), dtype=np.float64)
    pressure = np.asarray(np.diff(impulse) / pause / (width * dx), dtype=np.float64)
    return Press(width, sinkage, pressure, int(sim.state.count), sim.steps)


@dataclass(frozen=True)
class Fit:
    """Hold Bekker's p = (k_c / b + k_phi) z^n, fitted to plates; `scatter`: root mean square of ln p."""

    k_c: float
    k_phi: float
    n: float
    scatter: float

    def pressure(self, width: Array | float, z: Array | float) -> Array:
        """Return the pressure [Pa] under a plate of `width` [m] at the sinkage `z` [m]."""
        return np.asarray((self.k_c / np.asarray(width) + self.k_phi) * np.asarray(z) ** self.n)

    def load(self, z: float) -> float:
        """Return what bears a wheel that has sunk by `z` [m], per width [N/m].

        The pressure of a plate at the depth of each point of the front half of the arc, which is a plate as
        wide as that half is long; nothing bears behind the lowest point.
        """
        half = np.sqrt(z * (2 * RADIUS - z))
        x = half * (np.arange(400) + 0.5) / 400
        depth = np.sqrt(RADIUS**2 - x**2) - (RADIUS - z)
        return float(half * self.pressure(half, depth).mean())

    def sinkage(self, load: float) -> float:
        """Return the sinkage [m] of a wheel under `load` per width [N/m], by bisection."""
        low, high = 0.0, RADIUS
        for _ in range(50):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.load(middle) < load else (low, middle)
        return low


def fit(plates: list[Press], shallow: float = 0.25 * DX) -> Fit:
    """Fit Bekker's form to two plates, from the sinkage `shallow` [m] on, by least squares of ln p."""
    rows, values = [], []
    for i, plate in enumerate(plates):
        deep = plate.sinkage > shallow
        for z, p in zip(plate.sinkage[deep], plate.pressure[deep], strict=True):
            rows.append((np.log(z), *(float(i == j) for j in range(len(plates)))))
            values.append(np.log(p))
    A, y = np.array(rows), np.array(values)
    found = np.linalg.lstsq(A, y, rcond=None)[0]
    widths = np.array([plate.width for plate in plates])
    k_c, k_phi = np.polyfit(1 / widths, np.exp(found[1:]), 1)
    return Fit(float(k_c), float(k_phi), float(found[0]), float(np.sqrt(((A @ found - y) ** 2).mean())))


@dataclass(frozen=True)
class Drive:
    """Hold a steady drive.

    Attributes:
        sinkage: of the lowest point below the surface [m]
        slip: 1 - speed of the axle over that of the rim [1]
        borne, pull: forces of the snow on the wheel, upward and forward, over the load [1]
    """

    sinkage: float
    slip: float
    borne: float
    pull: float
    particles: int
    steps: int


def drive(load: float, pull: float = 0.0, dx: float = DX, seconds: float = SECONDS) -> Drive:
    """Drive a wheel under `load` per width [N/m] that pulls `pull` times its load.

    Bodies: a sled that slides forward and is held back by the pull, a strut that slides up and down in it
    and is pressed down, the wheel that a motor turns on it; sled and strut are far above the snow.
    """
    length = START + 1.3 * SPEED * seconds + 0.4
    weight = load * dx
    mass = BARE * weight / G
    far = {
        "shape": "box",
        "center": [START, 0.5 * dx, 3.0],
        "size": [0.2, 0.2, 0.2],
        "joint": "slide",
        "contacts": False,
    }
    sim = simulation(
        [box((0, 0, -LAYER), (length, dx, 0))],
        ground(length, dx),
        bodies=[
            {
                **far,
                "mass": 0.1 * mass,
                "axis": [1.0, 0.0, 0.0],
                "velocity": [SPEED, 0.0, 0.0],
                "motor": force(-pull * weight),
            },
            {
                **far,
                "mass": 0.6 * mass,
                "axis": [0.0, 0.0, 1.0],
                "parent": 0,
                "motor": force((BARE - 1) * weight),
            },
            wheel(mass, dx),
        ],
        gravity=(0.0, 0.0, -G),
        precision="float32",
        dx=dx,
    )
    rows = []
    sim.advance(STEADY)
    begun, impulse = sim.time, sim.exchanged[-1].copy()
    while sim.time < seconds - 1e-9:
        sim.advance(0.01)
        now = sim.solids()[-1][1]
        rows.append((RADIUS - now.position[2], now.velocity[0], now.omega[1] * RADIUS))
    sinkage, speed, rim = np.mean(rows, axis=0)
    force_on = (sim.exchanged[-1] - impulse) / (sim.time - begun) / weight
    return Drive(
        sinkage=float(sinkage),
        slip=float(1 - speed / rim),
        borne=float(force_on[2]),
        pull=float(force_on[0]),
        particles=int(sim.state.count),
        steps=sim.steps,
    )


def wheel(mass: float, dx: float) -> dict[str, Any]:
    """Return the wheel: 40 % of `mass` [kg]; its motor keeps it turning within a few per cent."""
    inertia = 0.5 * 0.4 * mass * RADIUS**2
    return {
        "shape": "cylinder",
        "center": [START, 0.5 * dx, RADIUS],
        "rotation": [90.0, 0.0, 0.0],
        "radius": RADIUS,
        "height": 4 * dx,
        "mass": 0.4 * mass,
        "joint": "hinge",
        "axis": [0.0, 1.0, 0.0],
        "spin": [0.0, SPEED / RADIUS, 0.0],
        "parent": 1,
        "contacts": False,
        "mu_c": 0.5,
        "motor": {"kind": "velocity", "target": SPEED / RADIUS, "gain": inertia / 1e-3},
    }


def force(newtons: float) -> dict[str, Any]:
    """Return a motor that pushes with a force that grows to `newtons` in RAMP."""
    return {"kind": "torque", "keyframes": [{"t": 0.0, "value": 0.0}, {"t": RAMP, "value": newtons}]}


LOADS = (2000.0, 4000.0, 6000.0, 8000.0)
"""Per width [N/m]."""
PULLS = (0.1, 0.2, 0.3)
"""Over the load [1]."""
WIDTHS = (0.12, 0.24)
"""Of the plates [m]."""
FACTOR = 2.0
"""So far a wheel may be off what plates predict [1]."""


def case(
    loads: tuple[float, ...] = LOADS, pulls: tuple[float, ...] = PULLS, widths: tuple[float, ...] = WIDTHS
) -> Result:
    """Measure sinkage and slip over loads, slip over pulls at the second load, and press plates."""
    plates = [press(width) for width in widths]
    drives = {load: drive(load) for load in loads}
    pulling = {0.0: drives[loads[1]], **{pull: drive(loads[1], pull) for pull in pulls}}
    found = fit(plates)
    runs: list[Press | Drive] = [*plates, *drives.values(), *(pulling[pull] for pull in pulls)]
    return Result(
        what=f"A rigid smooth wheel of {2 * RADIUS:g} m, turned by a motor with {SPEED:g} m/s at its rim, "
        f"free to move forward, up and down, drives over default snow, {LAYER:g} m deep; friction 0.5. Two "
        f"plates are pressed into the same snow. Plane strain: a slab of one cell of {DX:g} m, so loads are "
        "per width. Means over the last half second.",
        equations=(
            "<i>p</i> = (<i>k</i><sub>c</sub>/<i>b</i> + <i>k</i><sub>&phi;</sub>) "
            "<i>z</i><sup><i>n</i></sup>",
            "<i>W</i> = &int; <i>p</i>(<i>z</i>(<i>x</i>)) d<i>x</i> &nbsp; over the front half of the arc "
            "in the snow",
        ),
        source="Bekker's form, constants fitted to the plates; the wheel on it is Bekker's too, with the "
        "circle as it is. Neither is an exact answer: real wheels are off it as well.",
        checks=_checks(drives, pulling, found),
        plots=_plots(plates, drives, pulling, found),
        verdict="A wheel sinks deeper under more load, less than plates make one expect, and slips more the "
        "more it pulls, until it digs in.",
        particles=sum(run.particles for run in runs),
        steps=sum(run.steps for run in runs),
        remarks=(
            f"Fitted: k<sub>c</sub> = {found.k_c:.3g} Pa m<sup>1&minus;n</sup>, k<sub>&phi;</sub> = "
            f"{found.k_phi:.3g} Pa m<sup>&minus;n</sup>, n = {found.n:.3f}, scatter "
            f"{100 * found.scatter:.0f} % of the pressure. The form leaves out what friction at the rim "
            "bears, what bears behind the lowest point, and the snow that a wheel pushes ahead of itself.",
            "Without a pull the slip is negative: a rim that is deep in the snow moves backward against it "
            "in front even if it turns a little too slowly, and that alone drives the wheel.",
        ),
    )


def _checks(drives: dict[float, Drive], pulling: dict[float, Drive], found: Fit) -> tuple[Check, ...]:
    sinkage = np.array([run.sinkage for run in drives.values()])
    expected = np.array([found.sinkage(load) for load in drives])
    slip = np.array([pulling[pull].slip for pull in sorted(pulling)])
    ratio = sinkage / expected
    return (
        at_least("least factor of sinkage to the next load", (sinkage[1:] / sinkage[:-1]).min(), 1.0, "more"),
        at_most(
            "largest factor between a wheel's sinkage and that from plates",
            float(np.maximum(ratio, 1 / ratio).max()),
            FACTOR,
            "our own mark: friction and the snow in front of the wheel are not in the form",
        ),
        at_most(
            "scatter of plates about the fit, of ln p",
            found.scatter,
            0.2,
            "our own mark; cells that give way one after another make steps",
        ),
        at_most(
            "farthest that the snow's force is from the load, over the load",
            float(max(abs(run.borne - 1) for run in (*drives.values(), *pulling.values()))),
            0.03,
            "the snow carries a steady wheel; the rest is remaining bounce",
        ),
        at_most(
            "farthest that the snow's push is from the pull, over the load",
            float(max(abs(run.pull - pull) for pull, run in pulling.items())),
            0.03,
            "as above",
        ),
        at_least("least growth of slip to the next pull", float(np.diff(slip).min()), 0.0, "more"),
    )


def _plots(
    plates: list[Press], drives: dict[float, Drive], pulling: dict[float, Drive], found: Fit
) -> tuple[Plot, ...]:
    loads = np.array(sorted(drives))
    fine = np.linspace(loads[0], loads[-1], 40)
    pulls = np.array(sorted(pulling))
    deep = np.linspace(0.005, PLATE_WAY, 60)
    return (
        Plot(
            "Plates",
            "sinkage [m]",
            "pressure [kPa]",
            tuple(
                curve
                for plate in plates
                for curve in (
                    Curve(f"plate of {plate.width:g} m", plate.sinkage, 1e-3 * plate.pressure),
                    Curve("", deep, 1e-3 * found.pressure(plate.width, deep), "other"),
                )
            ),
        ),
        Plot(
            "Sinkage",
            "load per width [kN/m]",
            "sinkage [m]",
            (
                Curve("wheel", 1e-3 * loads, np.array([drives[load].sinkage for load in loads]), "joined"),
                Curve("from the plates", 1e-3 * fine, np.array([found.sinkage(w) for w in fine]), "other"),
            ),
        ),
        Plot(
            "Slip over load, without a pull",
            "load per width [kN/m]",
            "slip [1]",
            (Curve("wheel", 1e-3 * loads, np.array([drives[load].slip for load in loads]), "joined"),),
        ),
        Plot(
            f"Slip over pull, {1e-3 * loads[1]:g} kN/m",
            "pull over load [1]",
            "slip [1]",
            (Curve("wheel", pulls, np.array([pulling[pull].slip for pull in pulls]), "joined"),),
        ),
    )
