"""Describe in words what a field of a scene may hold."""

from __future__ import annotations

import types
from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from neve.scene.values.kinds import Kind, OneOf, kind_of

COUNT = {2: "two", 3: "three"}
LIMITS = (("gt", "greater than"), ("ge", "at least"), ("lt", "less than"), ("le", "at most"))


def unit(field: FieldInfo) -> str:
    """Return the unit of `field`: "1" for a pure number, "" for a word."""
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) else ""


def source(field: FieldInfo) -> str:
    """Return where the default of `field` comes from."""
    extra = field.json_schema_extra
    return str(extra["source"]) if isinstance(extra, dict) else ""


def words(choices: Sequence[str | int]) -> str:
    """Join `choices` as `"a", "b" or "c"`; numbers stand without quotes."""
    quoted = [str(choice) if isinstance(choice, int) else f'"{choice}"' for choice in choices]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def allowed(field: FieldInfo) -> str:
    """Return what `field` may hold, such as `a number greater than 0 and at most 1 [s]`."""
    text = _text(kind_of(field.annotation, field.metadata))
    label = unit(field)
    return f"{text} [{label}]" if label not in ("", "1") else text


def choices(field: FieldInfo) -> tuple[str, ...]:
    """Return the words that `field` may hold; nothing if it holds no words."""
    found = [name for mark in field.metadata if isinstance(mark, OneOf) for name in mark.registry.names()]
    for part in (field.annotation, *get_args(field.annotation)):
        if get_origin(part) is Literal:
            found += [choice for choice in get_args(part) if isinstance(choice, str)]
    return tuple(found)


def part(annotation: Any) -> type[BaseModel] | None:
    """Return the model of `annotation`, optional or not, if it is a part of a scene with keys of its own."""
    kinds = get_args(annotation) if get_origin(annotation) is types.UnionType else (annotation,)
    found = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
    return found[0] if found else None


def _text(kind: Kind) -> str:
    if kind.name == "choice":
        return words(kind.choices)
    if kind.name == "union":
        return " or ".join(map(_text, kind.members))
    if kind.name in ("vector", "list"):
        one = _text(kind.members[0])
        plural = one.replace("a number", "numbers").replace("a whole number", "whole numbers")
        if kind.name == "vector":
            return f"a list of {COUNT[kind.count]} {plural}"
        return f"a list of {plural}" if "numbers" in plural else "a list of tables"
    if kind.name == "text":
        return "text in quotes" + (", not empty" if kind.min_length else "")
    if kind.name in ("integer", "number"):
        return f"a {'whole number' if kind.name == 'integer' else 'number'}{_limits(kind.limits)}"
    return "true or false" if kind.name == "switch" else "a table"


def _limits(limits: dict[str, float]) -> str:
    if set(limits) == {"ge", "le"}:
        return f" from {_number(limits['ge'])} to {_number(limits['le'])}"
    parts = [f"{words} {_number(limits[name])}" for name, words in LIMITS if name in limits]
    return f" {' and '.join(parts)}" if parts else ""


def _number(value: float) -> str:
    return str(int(value)) if float(value).is_integer() and abs(value) < 1e10 else f"{value:g}"
