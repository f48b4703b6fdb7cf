"""What a sweep takes from a run: a column at a time or as an extreme, fragments, a function of yours."""

from __future__ import annotations

import importlib.util
import math
import numbers
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from neve.io.errors import RunError
from neve.io.log import columns, read_log
from neve.io.run_folder import RunFolder
from neve.io.table import WORDS, Row, read_table
from neve.spelling import hint, nearest

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene

WHEN: dict[str, Callable[[Any, Any], float]] = {
    "first": lambda time, value: value[0],
    "last": lambda time, value: value[-1],
    "max": lambda time, value: np.max(value),
    "min": lambda time, value: np.min(value),
    "mean": lambda time, value: np.mean(value),
    "time_of_max": lambda time, value: time[np.argmax(value)],
    "time_of_min": lambda time, value: time[np.argmin(value)],
}
"""Words for a moment or an extreme, over the frames that have a value."""
FRAGMENTS = "fragments"
EXAMPLE = (
    "write NAME=COLUMN@WHEN, such as peak=kinetic@max, push=force_z[colliders.0]@max or late=elastic@0.5"
)


@dataclass(frozen=True)
class Measure:
    """Hold one column of the table of a sweep: a column of the log, of a solid, or of the fragments.

    when: a word of WHEN or a time [s], for which the nearest frame is taken
    """

    name: str
    column: str
    solid: str = ""
    when: str | float = "last"

    def of(self, run: RunFolder, scene: Scene) -> float:
        """Return the value in a run, NaN if no frame or no run of this kind has one. Errors: RunError."""
        if self.solid == FRAGMENTS:
            return _fragments(run, self.column)
        if not self._is_of(scene):
            return math.nan
        rows = _solid(run, self.solid) if self.solid else _log(run, scene)
        time = np.array([float(row["time"]) for row in rows])
        text = [row[self.column] for row in rows]
        is_there = np.array([bool(word) for word in text])
        if not is_there.any():
            return math.nan
        time, value = time[is_there], np.array([float(word) for word in text if word])
        if isinstance(self.when, str):
            return float(WHEN[self.when](time, value))
        half = 0.5 / scene.run.fps
        if not time[0] - half <= self.when <= time[-1] + half:
            raise RunError(
                f"{self.name}: the run has no frame at {self.when:g} s; its last is at {time[-1]:g} s."
            )
        return float(value[np.argmin(np.abs(time - self.when))])

    def _is_of(self, scene: Scene) -> bool:
        if self.solid:
            return self.solid in _solids(scene)
        return self.column in _names(scene)


def read_measure(text: str) -> Measure:
    """Return what the text of `--output` says. Errors: RunError, one sentence."""
    name, equals, what = (part.strip() for part in text.partition("="))
    column, at, moment = (part.strip() for part in (what or name).partition("@"))
    solid = ""
    if column.endswith("]"):
        column, _, solid = column[:-1].partition("[")
    elif column.startswith(f"{FRAGMENTS}."):
        solid, _, column = column.partition(".")
    if not name or not column or (equals and not what) or (at and not moment):
        raise RunError(f"--output {text}: {EXAMPLE}.")
    return Measure(name, column, solid, _moment(moment or "last", text))


def _moment(word: str, text: str) -> str | float:
    if word in WHEN:
        return word
    try:
        time = float(word)
    except ValueError:
        time = math.nan
    if not (math.isfinite(time) and time >= 0):
        known = f"a time [s] or one of {', '.join(WHEN)}"
        raise RunError(f"--output {text}: there is no {word}{hint(nearest(word, WHEN), known)}.")
    return time


def kinds(scenes: Iterable[Scene]) -> list[Scene]:
    """Return one of all scenes whose runs have the same columns and solids, the first ones first."""
    found: dict[object, Scene] = {}
    for scene in scenes:
        kind = _names(scene), len(scene.colliders), len(scene.bodies), str(scene.robots)
        found.setdefault(kind, scene)
    return [*found.values()]


def usual(kinds: Sequence[Scene]) -> list[Measure]:
    """Return what a sweep takes unless told: numbers of the log, without wall times, at the last frame."""
    return [
        Measure(name, name)
        for name in _all_names(kinds)
        if name not in ("frame", *WORDS) and not name.startswith("seconds_")
    ]


def check(measures: Sequence[Measure], kinds: Sequence[Scene]) -> None:
    """Refuse what no run of these scenes has, before any begins. Errors: RunError."""
    from neve.fragments import SUMMARY
    from neve.run.outputs.solids import COLUMNS

    for measure in measures:
        if measure.solid == FRAGMENTS:
            known: Sequence[str] = SUMMARY
        elif measure.solid:
            known = [name for name in COLUMNS if name not in ("frame", *WORDS)]
            solids = _solids(*kinds)
            if measure.solid not in solids:
                meant = hint(nearest(measure.solid, solids), f"the scene has {', '.join(solids) or 'none'}")
                raise RunError(f"output {measure.name}: there is no solid {measure.solid}{meant}.")
        else:
            known = [name for name in _all_names(kinds) if name not in WORDS]
        if measure.column not in known:
            meant = hint(nearest(measure.column, known), f"use one of {', '.join(known)}")
            raise RunError(f"output {measure.name}: there is no column {measure.column}{meant}.")


def _names(scene: Scene) -> tuple[str, ...]:
    numerics = scene.numerics
    return columns(numerics.method, scene.is_open, scene.heat is not None, numerics.is_implicit)


def _all_names(kinds: Sequence[Scene]) -> list[str]:
    return list(dict.fromkeys(name for scene in kinds for name in _names(scene)))


def _solids(*scenes: Scene) -> list[str]:
    from neve.build import solids

    return list(dict.fromkeys(solid.name for scene in scenes for solid in solids(scene)))


def _log(run: RunFolder, scene: Scene) -> list[Row]:
    numerics = scene.numerics
    return read_log(run.log, numerics.method, scene.is_open, scene.heat is not None, numerics.is_implicit)


def _solid(run: RunFolder, name: str) -> list[Row]:
    from neve.run.outputs.solids import COLUMNS, FILE

    return [row for row in read_table(run.path / FILE, COLUMNS) if row["solid"] == name]


def _fragments(run: RunFolder, column: str) -> float:
    from neve.fragments import summary
    from neve.run.outputs.fragments import last_of

    return summary(last_of(run.path))[column]


@dataclass(frozen=True)
class Own:
    """Hold a function of the user's: of the run folder's path, it returns a number, or numbers by name."""

    path: str
    function: str

    def of(self, run: RunFolder) -> dict[str, float]:
        """Return what the function says of a run. Errors: RunError, one sentence."""
        call = self.load()
        where = f"{self.path}:{self.function}"
        try:
            found = call(run.path)
        except Exception as error:
            raise RunError(f"{where} failed on {run.path} ({type(error).__name__}: {error}).") from error
        named = found if isinstance(found, dict) else {self.function: found}
        for name, value in named.items():
            if not isinstance(name, str) or not isinstance(value, numbers.Real):
                raise RunError(f"{where} returned {value!r} for {name!r}: a number, or numbers by name.")
        return {name: float(value) for name, value in named.items()}

    def load(self) -> Callable[[Path], Any]:
        """Return the function. Errors: RunError, one sentence."""
        path = Path(self.path)
        try:
            spec = importlib.util.spec_from_file_location(f"neve_sweep_{path.stem}", path)
            if spec is None or spec.loader is None:
                raise ImportError("it is no Python file")
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        except Exception as error:
            raise RunError(
                f"--function {self.path}: it cannot be read ({type(error).__name__}: {error})."
            ) from error
        call = getattr(module, self.function, None)
        if not callable(call):
            raise RunError(f"--function {self.path}: it has no function {self.function}.")
        return call  # type: ignore[no-any-return]


def read_function(text: str) -> Own:
    """Return what the text of `--function`, FILE.py:NAME, says. Errors: RunError, one sentence."""
    path, colon, name = text.rpartition(":")
    if not colon or not path.endswith(".py") or not name.isidentifier():
        raise RunError(f"--function {text}: write FILE.py:NAME, such as mine.py:depth_of_crater.")
    own = Own(str(Path(path).resolve()), name)
    own.load()
    return own
