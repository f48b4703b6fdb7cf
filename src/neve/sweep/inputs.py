"""The inputs of runs: which points mean the same run, and what a row of the table says of each key."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel

from neve.scene.errors import SceneError
from neve.scene.reading.paths import follow
from neve.scene.schema.scene import Scene
from neve.sweep.design import Point, changes_of, toml_of

_EXACT = 2.0**53
"""Up to here every whole number is a float."""


def name_of(changes: Sequence[str]) -> str:
    """Return a text that is the same for changes with the same meaning: in any order, 5 or 5.0.

    Where a key lies inside another one the order counts, and is kept.
    """
    held: dict[str, str] = {}
    for change in changes:
        key, _, word = (part.strip() for part in change.partition("="))
        held.pop(key, None)
        held[key] = _normal(word)
    parts = [f"{key}={word}" for key, word in held.items()]
    nested = any(inner.startswith(f"{outer}.") for outer in held for inner in held)
    return " ".join(parts if nested else sorted(parts))


def distinct(points: Sequence[Point]) -> list[Point]:
    """Return the points without those that mean the same run as an earlier one."""
    found: dict[str, Point] = {}
    for point in points:
        found.setdefault(name_of(changes_of(point)), point)
    return [*found.values()]


def inputs_of(points: Sequence[Point], scenes: Sequence[Scene | SceneError]) -> list[Point]:
    """Return what each row says of every key that some run varies: where its run does not, the scene's own.

    None stands where the scene has no such value.
    """
    keys = dict.fromkeys(key for point in points for key in point)
    given = {key: [point[key] for point in points if key in point] for key in keys}
    return [
        {key: point[key] if key in point else _own(scene, key, given[key]) for key in keys}
        for point, scene in zip(points, scenes, strict=True)
    ]


def _own(scene: Scene | SceneError, key: str, given: Sequence[Any]) -> Any:
    """Return the value that a scene has at a key, written as another run was given it."""
    if isinstance(scene, SceneError):
        return None
    try:
        value = follow(scene, key.split("."))
    except KeyError:
        return None
    if value is None or isinstance(value, (BaseModel, dict)):
        return None
    if isinstance(value, (tuple, list)):
        return list(value) if all(isinstance(item, (int, float, str)) for item in value) else None
    return next((other for other in given if other == value and not isinstance(other, bool)), value)


def _normal(word: str) -> str:
    try:
        value = tomllib.loads(f"v = {word}")["v"]
    except (tomllib.TOMLDecodeError, KeyError):
        value = word
    return toml_of(_whole(value))


def _whole(value: Any) -> Any:
    if isinstance(value, float) and value.is_integer() and abs(value) <= _EXACT:
        return int(value)
    if isinstance(value, list):
        return [_whole(item) for item in value]
    if isinstance(value, dict):
        return {key: _whole(item) for key, item in value.items()}
    return value
