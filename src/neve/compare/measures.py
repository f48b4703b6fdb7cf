"""What a comparison measures of a run: time, steps, energies, momentum, spread, fragments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.diagnostics import Balance
from neve.fragments import find
from neve.io.log import read_log
from neve.io.log import stages as stages_of
from neve.simulation import Simulation


@dataclass(frozen=True)
class Measures:
    """Hold what is known of one method's run at its last frame.

    particles [1], steps [1], dt: mean step [s]; seconds: of wall time in the steps [s], and for a million
    particles moved once, seconds_per_million [s]; mass [kg]; kinetic and elastic energy [J], `lost`: energy
    of the snow at the start, what colliders did, and what snow brought that came, less that at the end and
    what left with snow [J]; momentum: |sum m v| [kg m/s]; height: of the centre of mass [m]; spread: root
    mean square distance from it [m]; fragments [1], and largest: share of the mass in the largest [1].
    NaN where the method cannot say, or where no snow is left.
    """

    particles: int
    steps: int
    dt: float
    seconds: float
    seconds_per_million: float
    mass: float
    kinetic: float
    elastic: float
    lost: float
    momentum: float
    height: float
    spread: float
    fragments: float
    largest: float


@dataclass(frozen=True)
class Curve:
    """Hold the kinetic energy [J] over time [s] of a run, both (frames,)."""

    time: NDArray[np.float64]
    kinetic: NDArray[np.float64]


UNITS = {
    "particles": "", "steps": "", "dt": "s", "seconds": "s", "seconds_per_million": "s", "mass": "kg",
    "kinetic": "J", "elastic": "J", "lost": "J", "momentum": "kg m/s", "height": "m", "spread": "m",
    "fragments": "", "largest": "",
}  # fmt: skip
"""Units of the members of `Measures`."""


def measured(sim: Simulation, log: Path) -> tuple[Measures, Curve]:
    """Return the measures of a run that ended in `sim`, and its curve, from its log. Errors: RunError."""
    scene = sim.scene
    method = scene.numerics.method
    rows = read_log(log, method, scene.is_open, scene.heat is not None, scene.numerics.is_implicit)
    inside = [f"seconds_{stage}" for stage in stages_of(method) if stage not in ("write", "film")]
    seconds = sum(float(row[name] or 0) for row in rows for name in inside)
    columns = sim.columns()
    x = np.asarray(columns["x"](), dtype=np.float64)
    m = np.asarray(columns["m"](), dtype=np.float64) if "m" in columns else np.ones(len(x))
    height, spread = _extent(x, m)
    last = _energies(rows[-1])
    fragments, largest = _fragments(sim, x, m)
    moved = max(1, len(x) * sim.steps)
    measures = Measures(
        particles=len(x),
        steps=sim.steps,
        dt=sim.time / max(1, sim.steps),
        seconds=seconds,
        seconds_per_million=1e6 * seconds / moved,
        mass=float(np.sum(m)) if "m" in columns else math.nan,
        kinetic=last["kinetic"],
        elastic=last["elastic"],
        lost=_lost(rows[0], rows[-1]),
        momentum=math.hypot(*(last[f"momentum_{axis}"] for axis in "xyz")),
        height=height,
        spread=spread,
        fragments=fragments,
        largest=largest,
    )
    curve = Curve(
        np.array([float(row["time"]) for row in rows]), np.array([_energies(row)["kinetic"] for row in rows])
    )
    return measures, curve


def _energies(row: dict[str, str]) -> dict[str, float]:
    """Return the sums of a row of the log that a comparison takes; NaN where the method has none."""
    names = ("kinetic", "elastic", "momentum_x", "momentum_y", "momentum_z")
    return {name: float(row[name]) if row.get(name) else math.nan for name in names}


def _lost(first: dict[str, str], last: dict[str, str]) -> float:
    """Return what is lost between two rows of a log [J]; NaN where the method has no energies."""
    if not {"kinetic", "elastic", "potential", "work"} <= first.keys():
        return math.nan
    return -Balance.of_row(last).growth(Balance.of_row(first))


def _extent(x: NDArray[np.float64], m: NDArray[np.float64]) -> tuple[float, float]:
    """Return the height of the centre of mass of x (n, 3), and the root mean square distance from it [m]."""
    if not len(x):
        return math.nan, math.nan
    centre = np.average(x, axis=0, weights=m)
    return float(centre[2]), math.sqrt(float(np.average(np.sum((x - centre) ** 2, axis=1), weights=m)))


def _fragments(sim: Simulation, x: NDArray[Any], m: NDArray[Any]) -> tuple[float, float]:
    """Return the number of fragments and the share of the mass in the largest, NaN where it is not known."""
    columns = sim.columns()
    if not {"J_P", "m", "V0"} <= columns.keys() or not len(x):
        return math.nan, math.nan
    J_P, V0 = (np.asarray(columns[name](), dtype=np.float64) for name in ("J_P", "V0"))
    found = find(x, np.asarray(columns["v"]()), J_P, m, V0, sim.scene.numerics.spacing)
    return float(found.count), float(np.max(found.mass[1:], initial=0.0) / np.sum(m))
