"""Shorter steps, same cells: what a press measures must not depend on dt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.validate.result import Check, Curve, Plot, Result, near
from neve.validate.scenes import box, plane, simulation, slab

Array = NDArray[np.float64]

SIDE, RATE, LAST = 0.2, 10.0, 0.7
"""Of the block [m], of its height that goes in a second [1/s], and what is left of it [1]."""

SNOWS: dict[str, dict[str, Any]] = {
    "stomakhin2013": {},
    "drucker_prager": {"law": "drucker_prager", "E0": 1e6, "cohesion": 1e4},
    "cam_clay": {"law": "cam_clay", "p0": 3e4, "beta": 0.3},
}

CFLS = (0.4, 0.1, 0.025)
WAYS: dict[str, dict[str, Any]] = {
    "apic": {"transfer": "apic"},
    "flip": {"transfer": "flip", "flip_alpha": 1.0},
    "aflip": {"transfer": "aflip"},
}
SETTLES = "aflip"
"""The transfer whose answer is required to settle."""


@dataclass(frozen=True)
class Press:
    """Hold the mean pressure [Pa] on both plates over the last fifth of the way, and the size of the work."""

    pressure: float
    particles: int
    steps: int


def press(snow: dict[str, Any], cells: int = 16, **numerics: Any) -> Press:
    """Squeeze a block of snow to `LAST` of its height between plates that it sticks to, in plane strain.

    The upper plate moves, the sides are free. The block is one cell thick between smooth walls.
    """
    h = SIDE / cells
    sim = simulation(
        [box((0, 0, 0), (SIDE, h, SIDE))],
        [
            plane((0, 0, 0), (0, 0, 1), "sticky"),
            plane((0, 0, SIDE), (0, 0, -1), "sticky", velocity=[0.0, 0.0, -RATE * SIDE]),
            *slab(h),
        ],
        snow=snow,
        dx=h,
        precision="float32",
        **numerics,
    )
    seconds = (1 - LAST) / RATE
    sim.advance(0.8 * seconds)
    before = np.array(sim.exchanged)
    sim.advance(seconds - sim.time)
    impulse = np.asarray(sim.exchanged) - before
    pressure = 0.5 * (impulse[1, 2] - impulse[0, 2]) / (0.2 * seconds * SIDE * h)
    return Press(float(pressure), int(sim.state.count), sim.steps)


def checks_of(law: str, pressure: Array, cfls: tuple[float, ...]) -> list[Check]:
    """Return the checks that the pressures [Pa] at the steps `cfls` are those at the shortest."""
    reason = "first order in dt: a quarter of the step, a quarter of the error; 3 % is required of Neve"
    usual = "the longest step is the usual one: 5 % is required of Neve"
    title = f"{law}, {SETTLES}: pressure at cfl {{}}, against {cfls[-1]}"
    return [
        near(title.format(cfl), p, pressure[-1], 0.03 if k else 0.05, reason if k else usual, "Pa")
        for k, (cfl, p) in enumerate(zip(cfls[:-1], pressure[:-1], strict=True))
    ]


def case(cells: int = 16, cfls: tuple[float, ...] = CFLS) -> Result:
    """Measure the pressure of a press at shorter and shorter steps, for three laws and transfers."""
    found = {
        (law, name): [press(snow, cells, cfl=cfl, **how) for cfl in cfls]
        for law, snow in SNOWS.items()
        for name, how in WAYS.items()
    }
    pressure = {key: np.array([run.pressure for run in runs]) for key, runs in found.items()}
    runs = [run for each in found.values() for run in each]
    return Result(
        what=f"A block of snow of {SIDE} m ({cells} cells) is squeezed to {LAST:g} of its height in plane "
        f"strain, by {RATE:g} heights a second, between plates that it sticks to, at steps of cfl {cfls[0]} "
        "and shorter with the same cells. The pressure is the mean on both plates over the last fifth of the "
        "way.",
        equations=(
            "apic: a wave of the grid fades as exp(&minus;(1 &minus; <i>s</i>) <i>t</i> / <i>dt</i>), "
            "1 &minus; <i>s</i> ~ (<i>k dx</i>)<sup>4</sup> / 41",
            "aflip: as exp(&minus;<i>r</i> (1 &minus; <i>s</i>) <i>t</i>), <i>r</i> = <i>&kappa; c</i> / "
            "<i>dx</i>",
        ),
        source="No exact pressure is known: what is checked is that there is a limit as dt shrinks.",
        checks=tuple(check for law in SNOWS for check in checks_of(law, pressure[law, SETTLES], cfls)),
        plots=tuple(
            Plot(
                f"Pressure of the press, {law}",
                "cfl [1]",
                "pressure [Pa]",
                tuple(Curve(name, np.array(cfls), pressure[law, name], "joined") for name in WAYS),
                "log",
            )
            for law in SNOWS
        ),
        verdict=f"With {SETTLES} the pressure has a limit. With apic, which loses motion in each step, "
        "shorter steps make snow more viscous.",
        particles=sum(run.particles for run in runs),
        steps=sum(run.steps for run in runs),
        remarks=tuple(
            f"{law}, {name}: {', '.join(f'{p / 1e3:.1f}' for p in pressure[law, name])} kPa at cfl "
            f"{', '.join(map(str, cfls))}"
            for law in SNOWS
            for name in WAYS
        ),
    )
