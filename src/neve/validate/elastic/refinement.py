"""Errors fall with the cell size: the bar at h, h/2, h/4 with equal particles in a cell (known answer 27)."""

from __future__ import annotations

from typing import Any

import numpy as np

from neve.validate.elastic.bar import vibrate
from neve.validate.result import Curve, Plot, Result, at_least, near
from neve.validate.scenes import transfers

CELLS = (10, 20, 40)
PERIODS = 1.125
"""An eighth past a full period, both displacement and velocity count: errors of phase and of height show."""


def errors(how: dict[str, Any], cells: tuple[int, ...] = CELLS) -> list[float]:
    """Return the error of the displacement at each number of cells, over the exact amplitude [1]."""
    return [vibrate(n, PERIODS, **how).error for n in cells]


def order(cells: tuple[int, ...], error: list[float]) -> float:
    """Return the slope of log(error) against log(h), between the coarsest and the finest [1]."""
    return float(np.log(error[0] / error[-1]) / np.log(cells[-1] / cells[0]))


def case(cells: tuple[int, ...] = CELLS) -> Result:
    """Measure the order of every transfer, and of the cubic spline."""
    ways: dict[str, dict[str, Any]] = {**transfers(), "apic, cubic": {"spline": "cubic"}}
    found = {name: errors(how, cells) for name, how in ways.items()}
    second = "2 in theory (lumped mass, splines, leapfrog); 1.5 is required of Neve"
    first = "its damping in a given time is k<sup>2</sup> h<sup>2</sup> / 4 a step, and steps shrink with h"
    checks = [
        near(f"{name}: order", order(cells, error), 1.0, 0.25, first)
        if name == "pic"
        else at_least(f"{name}: order", order(cells, error), 1.5, second)
        for name, error in found.items()
    ]
    h = 1.0 / np.asarray(cells, dtype=float)
    guides = (
        Curve("second order", h, 3.0 * h**2 * found["apic"][0] / h[0] ** 2, "other"),
        Curve("first order", h, 2.0 * h * max(found["pic"][0], 1e-9) / h[0], "other"),
    )
    return Result(
        what="The vibrating bar again, with the same particles in a cell and the same share of a cell in "
        "a step, "
        "on finer and finer grids. The error is the root mean square of the displacement after 9/8 of a "
        "period, "
        "against the exact solution.",
        equations=(
            "error &prop; <i>h</i><sup>p</sup>, &nbsp; p = "
            "log(<i>e</i><sub>h</sub>/<i>e</i><sub>h/4</sub>) / log 4",
        ),
        source="The exact solution of the vibrating bar.",
        checks=tuple(checks),
        plots=(
            Plot(
                "Error against cell size",
                "h / L [1]",
                "error over amplitude [1]",
                (*guides, *(Curve(name, h, np.asarray(error), "joined") for name, error in found.items())),
                "log",
                "log",
            ),
        ),
        verdict="Neve converges with second order, as the scheme should; PIC with first order, because it "
        "damps.",
        particles=0,
        steps=0,
    )
