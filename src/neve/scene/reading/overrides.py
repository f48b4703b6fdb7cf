"""Change single values of a scene that has been read but not yet checked: `--set snow.xi=12`."""

from __future__ import annotations

import tomllib
from typing import Any

from neve.scene.errors import SceneError
from neve.scene.reading.paths import is_index
from neve.scene.reading.validation_errors import shown
from neve.scene.schema.scene import Scene
from neve.scene.schema.tables import default_vector

EXAMPLE = "write key=value, such as numerics.dx=0.02 or sources.0.radius=0.3"


LONGEST = 200
"""Characters of an override that a sentence repeats."""


def named(text: str) -> str:
    """Return what a sentence calls the override `text`."""
    return f"--set {text}" if len(text) <= LONGEST else f"--set {text[:LONGEST]}..."


def override(data: dict[str, Any], text: str) -> tuple[str, ...]:
    """Set in `data` what `text` ("sources.0.radius=0.3") says, and return the path of the key.

    The value is read as TOML; a bare word counts as text. Entries of lists are numbered from 0.

    Errors: SceneError.
    """
    key, equals, value = text.partition("=")
    path = tuple(part.strip() for part in key.split("."))
    if not equals or not value.strip() or not all(path):
        raise SceneError(f"{named(text)}: {EXAMPLE}")
    _put(data, path, _parse(value.strip(), text), text)
    return path


def _parse(value: str, text: str) -> Any:
    try:
        table = tomllib.loads(f"v = {value}")
        if list(table) == ["v"]:
            return table["v"]
    except (tomllib.TOMLDecodeError, RecursionError):
        if value[0] in "[{\"'":
            raise SceneError(f"{named(text)}: the value is not valid TOML; {EXAMPLE}") from None
    return value


def _put(data: dict[str, Any], path: tuple[str, ...], value: Any, text: str) -> None:
    place: Any = data
    for depth, key in enumerate(path):
        last = depth == len(path) - 1
        here = ".".join(path[:depth])
        if isinstance(place, dict):
            if last:
                place[key] = value
                return
            if key not in place and path[depth + 1].isdigit():
                place[key] = default_vector(path[: depth + 1], data, Scene) or []
            place = place.setdefault(key, {})
        elif isinstance(place, list):
            index = _index(key, place, here, text)
            if last:
                place[index] = value
                return
            place = place[index]
        else:
            raise SceneError(f"{named(text)}: {here} = {shown(place)} is a single value and has no key {key}")


def _index(key: str, place: list[Any], here: str, text: str) -> int:
    if not place:
        raise SceneError(f"{named(text)}: {here} is empty in this scene, so no entry can be changed")
    range_ = "0 is the only one" if len(place) == 1 else f"use 0 to {len(place) - 1}"
    if not (key.isascii() and key.isdigit()):
        raise SceneError(
            f"{named(text)}: {here} is a list, so {here}.{key} needs the number of an entry: {range_}"
        )
    if not is_index(key, place):
        raise SceneError(f"{named(text)}: {here} has no entry {key}; {range_}")
    return int(key)
