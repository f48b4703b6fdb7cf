"""Write a scene as a person would: only what differs from what a scene has without it."""

from __future__ import annotations

import re
from typing import Any

import tomli_w

from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml
from neve.scene.schema.scene import Scene

NUMBERS = re.compile(r"\[\n((?: +[-+0-9.e]+,\n)+) *\]")
"""A list of numbers as tomli_w has it, one in a line."""


def short_toml(scene: Scene) -> str:
    """Return `scene` as TOML without the values that follow from the others; loading it gives an equal scene.

    A value that is its key's default is left out at once. Of a snow, whose kind and law bring constants of
    their own, each key is left out if the scene is the same without it.
    """
    tables = scene.model_dump(mode="json", exclude_defaults=True)
    whole = scene.model_dump(mode="json", exclude_none=True)
    for name, entries in tables.items():
        if isinstance(entries, list) and isinstance(whole[name], list):
            tables[name] = [
                _with_shape(entry, full) for entry, full in zip(entries, whole[name], strict=True)
            ]
    _put_snows(tables, whole)
    if not _is_same(tables, scene):
        return to_toml(scene)
    for place, key in list(_snows(tables)):
        for constant in list(place[key]):
            _leave_out(tables, place[key], constant, scene)
        _leave_out(tables, place, key, scene)
    return NUMBERS.sub(
        lambda found: f"[{', '.join(found[1].replace(',', ' ').split())}]", tomli_w.dumps(tables)
    )


def _with_shape(entry: Any, full: Any) -> Any:
    if not isinstance(entry, dict) or "shape" not in full:
        return entry
    return {"shape": full["shape"]} | entry


def _put_snows(tables: dict[str, Any], whole: dict[str, Any]) -> None:
    """Put the snows of `whole` into `tables` with all their constants."""
    for place, key in _snows(whole):
        if place is whole:
            tables[key] = dict(place[key])
    for name, entries in whole.items():
        if isinstance(entries, list):
            for entry, full in zip(tables.get(name, []), entries, strict=False):
                if isinstance(full, dict) and isinstance(full.get("snow"), dict):
                    entry["snow"] = dict(full["snow"])


def _snows(tables: dict[str, Any]) -> list[tuple[dict[str, Any], str]]:
    """Return each table that holds a snow, and its key there."""
    lists = [entry for entries in tables.values() if isinstance(entries, list) for entry in entries]
    places = [tables, *(entry for entry in lists if isinstance(entry, dict))]
    return [(place, "snow") for place in places if isinstance(place.get("snow"), dict)]


def _leave_out(tables: dict[str, Any], place: dict[str, Any], key: str, scene: Scene) -> None:
    """Take `key` out of `place` if `tables` are the same scene without it."""
    value = place.pop(key)
    if not _is_same(tables, scene):
        place[key] = value


def _is_same(tables: dict[str, Any], scene: Scene) -> bool:
    try:
        return scene_from(tables, where="") == scene
    except SceneError:
        return False
