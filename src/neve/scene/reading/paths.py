"""Follow the words of a dotted path, such as sources.0.radius, into tables, lists and parts of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel


def is_index(key: str, entries: Sequence[Any]) -> bool:
    """Say whether `key` is the number of one of the `entries`, counted from 0."""
    return key.isascii() and key.isdigit() and int(key) < len(entries)


def inside(place: Any, key: str) -> Any:
    """Return what `place` (a table, a list or a part of a scene) holds at `key`.

    Errors: KeyError if it holds nothing there.
    """
    if isinstance(place, dict):
        return place[key]
    if isinstance(place, list | tuple) and is_index(key, place):
        return place[int(key)]
    if isinstance(place, BaseModel) and key in type(place).model_fields:
        return getattr(place, key)
    raise KeyError(key)


def follow(place: Any, keys: Sequence[str]) -> Any:
    """Return what lies at `keys` below `place`. Errors: KeyError if there is nothing."""
    for key in keys:
        place = inside(place, key)
    return place
