"""A sweep as a file: its scene, what varies, and what is taken from each run."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from neve.io.errors import RunError, cannot_read
from neve.sweep.design import Point, Vary, grid, latin, of_range, of_values, together
from neve.sweep.measures import Measure, read_function, read_measure
from neve.sweep.run import Sweep
from neve.system import disk

DESIGNS = ("grid", "together", "latin")
"""How values are combined: all with all, first with first, or as a Latin hypercube."""


class Range(BaseModel):
    """Hold a range of a key in a plan."""

    model_config = ConfigDict(extra="forbid")
    low: float = Field(alias="from")
    high: float = Field(alias="to")
    count: int | None = None
    scale: Literal["linear", "log"] = "linear"


class Plan(BaseModel):
    """Hold a plan as its file has it."""

    model_config = ConfigDict(extra="forbid")
    scene: str
    set: list[str] = []
    vary: dict[str, list[Any] | Range] = {}
    points: list[dict[str, Any]] = []
    design: Literal["grid", "together", "latin"] = "grid"
    samples: int | None = None
    seed: int = 0
    outputs: dict[str, str] = {}
    functions: list[str] = []
    frames: int | None = Field(None, ge=1)


def read_plan(path: Path) -> Sweep:
    """Return the sweep of a file; names of files in it are seen from its folder. Errors: RunError."""
    try:
        data = tomllib.loads(disk.read_bytes(path).decode())
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, RecursionError) as error:
        raise RunError(f"{path}: this is not valid TOML ({error}).") from error
    try:
        plan = Plan.model_validate(data)
    except ValidationError as error:
        first = max(error.errors(), key=lambda found: len(found["loc"]))  # of a list or a range
        key = ".".join(str(part) for part in first["loc"] if part not in ("list[any]", "Range"))
        raise RunError(f"{path}: {key} = {first['input']!r}: {first['msg'].lower()}.") from None
    varied = [_vary(key, given, f"{path}: vary.{key}") for key, given in plan.vary.items()]
    return Sweep(
        scene=_beside(path, plan.scene),
        points=[*points_of(varied, plan.design, plan.samples, plan.seed), *map(_flat, plan.points)],
        changes=plan.set,
        measures=[_measure(name, text) for name, text in plan.outputs.items()],
        functions=[read_function(str(path.parent / text)) for text in plan.functions],
        frames=plan.frames,
    )


def points_of(varied: list[Vary], design: str, samples: int | None, seed: int) -> list[Point]:
    """Return the points of a design by its word, none if nothing varies. Errors: RunError."""
    if design == "latin" and samples is None:
        raise RunError("--design latin needs --samples: how many runs there are.")
    if design != "latin" and samples is not None:
        raise RunError(f"--samples is of --design latin, and this one is {design}.")
    if not varied:
        return []
    if design == "latin":
        return latin(varied, samples or 0, seed)
    return together(varied) if design == "together" else grid(varied)


def _vary(key: str, given: list[Any] | Range, where: str) -> Vary:
    if isinstance(given, Range):
        return of_range(key, given.low, given.high, given.count, given.scale == "log", where)
    if not given:
        raise RunError(f"{where} has no values.")
    return of_values(key, given, where)


def _measure(name: str, text: str) -> Measure:
    return read_measure(f"{name}={text}")


def _beside(path: Path, scene: str) -> str:
    """Return a scene as seen from here: a file beside the plan, or a preset."""
    file = path.parent / Path(scene).expanduser()
    return str(file) if file.exists() else scene


def _flat(point: dict[str, Any], before: str = "") -> Point:
    """Return a point with dotted keys, however its tables are written."""
    found: Point = {}
    for key, value in point.items():
        found |= _flat(value, f"{before}{key}.") if isinstance(value, dict) else {before + key: value}
    return found
