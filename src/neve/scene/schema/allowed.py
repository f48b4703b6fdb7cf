"""Describe in words what a field of a scene may hold."""

from __future__ import annotations

import types
from collections.abc import Sequence
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from neve.scene.schema.kinds import Kind, kind_of
from neve.scene.schema.outputs import OpenList

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
    found: list[str] = []
    for part in (field.annotation, *get_args(field.annotation)):
        if get_origin(part) is Literal:
            found += [choice for choice in get_args(part) if isinstance(choice, str)]
    return tuple(found)


def shapes(annotation: Any) -> dict[str, type[BaseModel]]:
    """Return the models of a list of shapes by the word that picks them; nothing for any other annotation."""
    if get_origin(annotation) is not tuple:
        return {}
    item = get_args(annotation)[0]
    if get_origin(item) is not Annotated:
        return {}
    union = get_args(item)[0]
    return {model.model_fields["shape"].default: model for model in get_args(union)}


def entry_models(annotation: Any) -> tuple[str, dict[str, type[BaseModel]]]:
    """Return the key that picks the model of a list's entry, "shape" or "kind", and the models by its word.

    There are no models for an annotation that is not such a list.
    """
    item = get_args(annotation)[0] if get_origin(annotation) is tuple else None
    for mark in getattr(item, "__metadata__", ()):
        if isinstance(mark, OpenList):
            return mark.tag, dict(mark.models())
    return "shape", shapes(annotation)


def part(annotation: Any) -> type[BaseModel] | None:
    """Return the model of `annotation`, optional or not, if it is a part of a scene with keys of its own."""
    kinds = get_args(annotation) if get_origin(annotation) is types.UnionType else (annotation,)
    found = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
    return found[0] if found else None


def table_of_list(annotation: Any) -> type[BaseModel] | None:
    """Return the model of each entry if `annotation` is a list of tables of one kind."""
    if get_origin(annotation) is not tuple or shapes(annotation):
        return None
    items = get_args(annotation)
    return part(items[0]) if items[-1] is Ellipsis else None


def default_vector(path: tuple[str, ...], data: dict[str, Any], owner: type[BaseModel]) -> list[Any] | None:
    """Return the default at `path` in `owner`, whose tables are `data`, if it is a list of numbers."""
    key, *rest = path
    field = owner.model_fields.get(key)
    if field is None:
        return None
    if not rest:
        return list(field.default) if isinstance(field.default, tuple) and field.default else None
    below = data.get(key, {})
    inner = part(field.annotation)
    if inner and isinstance(below, dict):
        return default_vector(tuple(rest), below, inner)
    shaped = shapes(field.annotation)
    if shaped and len(rest) > 1 and isinstance(below, list):
        entry = below[int(rest[0])]
        model = shaped.get(str(entry.get("shape"))) if isinstance(entry, dict) else None
        return default_vector(tuple(rest[1:]), entry, model) if model else None
    return None


def _text(kind: Kind) -> str:
    if kind.name == "choice":
        return words(kind.choices)
    if kind.name == "union":
        return " or ".join(map(_text, kind.members))
    if kind.name in ("vector", "list"):
        plural = _text(kind.members[0]).replace("a number", "numbers")
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
