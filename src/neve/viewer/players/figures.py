"""Figures of a run over time, which the page plots: sums over the snow, forces on solids, fragments."""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from neve.io.card import read_card
from neve.io.errors import RunError, cannot_read
from neve.io.table import WORDS
from neve.viewer.protocol.messages import FiguresMessage

if TYPE_CHECKING:
    from neve.io.run_folder import RunFolder
    from neve.simulation import Simulation

MOST_ROWS = 20_000
"""Rows that are told at most: of more, every k-th."""

MOST_BYTES = 256 * 2**20
"""Size of a table above which it is left out [bytes]."""

MOST_COUNTED = 50_000
"""Particles of a live run above which its fragments are not counted: it would take longer than a frame."""

UNITS = {
    "J": ("kinetic", "elastic", "potential", "affine", "work", "excess", "energy", "heat", "heat_taken"),
    "kg": ("mass", "water"),
    "kg m/s": ("momentum",),
    "N": ("force",),
    "N m": ("torque",),
    "m/s": ("velocity",),
    "rad/s": ("omega",),
    "m": ("x", "y", "z", "size"),
    "m3": ("volume",),
    "s": ("dt", "time", "min", "mean"),
}
"""Unit -> words of which a name's last one says it, without its axis."""


class Figures:
    """Hold a row of values by name for each frame."""

    def __init__(self) -> None:
        self._rows: dict[int, dict[str, float]] = {}
        self._names: list[str] = []
        self._told = 0  # columns that were told

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, frame: int, values: Mapping[str, float]) -> None:
        """Add values of a frame."""
        self._rows.setdefault(frame, {}).update(values)
        self._names += [name for name in values if name not in self._names]

    def message(self, first: int) -> FiguresMessage:
        """Return the rows from number `first` on; all of them if there are columns that were not told."""
        frames = sorted(self._rows)
        if self._told != len(self._names):
            first, self._told = 0, len(self._names)
        stride = -(-len(frames) // MOST_ROWS) if first == 0 else 1
        return {
            "kind": "figures",
            "first": first,
            "columns": [{"name": name, "unit": unit_of(name)} for name in self._names],
            "rows": [
                [float(frame), *(self._rows[frame].get(name) for name in self._names)]
                for frame in frames[first::stride]
            ],
        }


class Sampler:
    """Take the figures of a simulation, frame by frame."""

    def __init__(self) -> None:
        self._before: tuple[float, dict[str, object]] = (0.0, {})

    def values(self, sim: Simulation, with_fragments: bool) -> dict[str, float]:
        """Return what the log has, the mean force [N] and moment [N m] of the snow on each solid since the
        last call, and with_fragments how many pieces there are.
        """
        found = {"time": sim.time, **sim.solver.log_values(sim.diagnostics())}
        if sim.stats.steps:
            found |= {"dt_mean": sim.stats.dt_mean, "dt_min": sim.stats.dt_min}
        found |= self._forces(sim)
        if with_fragments and sim.count <= MOST_COUNTED:
            found |= _fragments(sim)
        return {name: float(value) for name, value in found.items()}

    def _forces(self, sim: Simulation) -> dict[str, float]:
        names = [solid.name for solid in sim.solver.solids]
        now = dict(zip(names, sim.exchanged[:, :6].copy(), strict=False))
        (then, before), self._before = self._before, (sim.time, dict(now))
        if sim.time <= then or list(before) != list(now):
            return {}
        found = {}
        for name in names:
            mean = (now[name] - np.asarray(before[name])) / (sim.time - then)
            for column, value in zip(
                ("force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"), mean, strict=True
            ):
                found[f"{name} {column}"] = float(value)
            found[f"{name} force"] = float(np.linalg.norm(mean[:3]))
        return found


def _fragments(sim: Simulation) -> dict[str, float]:
    from neve.fragments import find

    columns = sim.arrays()
    if not {"x", "v", "J_P", "m", "V0"} <= set(columns):
        return {}
    x, v, J_P, m, V0 = (np.asarray(columns[name]) for name in ("x", "v", "J_P", "m", "V0"))
    pieces = find(x, v, J_P, m, V0, 2 * sim.radius)
    return {
        "fragments": pieces.count,
        "fragments mass of the heaviest": float(pieces.mass[1]) if pieces.count else 0.0,
        "fragments mass of powder": float(pieces.mass[0]),
    }


def of_run(run: RunFolder) -> Figures:
    """Return the figures in the tables of a run. A table that is damaged ends where it is.

    Errors: RunError if the run's card or a table cannot be read.
    """
    figures = Figures()
    tables = [run.log, *(run.path / name for name in read_card(run.card).files if name.endswith(".csv"))]
    for path in dict.fromkeys(tables):
        if not path.is_file() or path.stat().st_size > MOST_BYTES:
            continue
        prefix = "" if path.name in (run.log.name, "solids.csv", "fragments.csv") else f"{path.stem} "
        for frame, rows in _by_frame(path):
            for row in rows:
                figures.add(frame, dict(_values(row, prefix)))
            if "kind" in rows[0]:
                figures.add(frame, {"fragments": sum(row["kind"] == "fragment" for row in rows)})
    return figures


def _by_frame(path: Path) -> Iterator[tuple[int, list[dict[str, str]]]]:
    found: dict[int, list[dict[str, str]]] = defaultdict(list)
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if None in row or None in row.values() or not str(row.get("frame", "")).isdigit():
                    break  # cut short by a crash, or still being written
                found[int(row["frame"])].append(row)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        if isinstance(error, OSError):
            raise cannot_read(path, error) from error
        raise RunError(f"{path} is damaged: it is no table.") from error
    return iter(found.items())


def _values(row: Mapping[str, str], prefix: str) -> Iterable[tuple[str, float]]:
    """Yield the numbers of a row by name: of a solid with its name before; of fragments, masses."""
    kind = row.get("kind")
    if kind is not None:
        what = {"powder": "powder", "fragment": "the heaviest" if row.get("rank") == "1" else ""}.get(
            kind, ""
        )
        if what:
            yield f"{prefix}fragments mass of {what}", float(row["mass"])
        return
    whose = f"{row['solid']} " if "solid" in row else prefix
    force = [number_of(row.get(f"force_{axis}", "")) for axis in "xyz"]
    if "solid" in row and None not in force:
        yield f"{whose}force", math.hypot(*(each for each in force if each is not None))
    for name, text in row.items():
        value = None if name == "frame" or name in WORDS else number_of(text)
        if value is not None:
            yield ("time" if name == "time" else f"{whose}{name}"), value


def number_of(text: str) -> float | None:
    """Return a finite number, None for any other text."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def unit_of(name: str) -> str:
    """Return the unit of a figure, as its name says; empty if it says none."""
    words = name.split(" ")[-1] if " mass of " not in name else "mass"
    if words.startswith("seconds_"):
        return "s"
    parts = words.split("_")
    if len(parts) > 1 and parts[-1] in ("x", "y", "z"):
        parts = parts[:-1]
    return next((unit for unit, known in UNITS.items() if parts[-1] in known or words in known), "")
