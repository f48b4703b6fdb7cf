"""Say in words what a field of a scene may hold."""

from __future__ import annotations

import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

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


def words(choices: tuple[str | int, ...] | list[str]) -> str:
    """Join `choices` as `"a", "b" or "c"`; numbers stand without quotes."""
    quoted = [str(choice) if isinstance(choice, int) else f'"{choice}"' for choice in choices]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def allowed(field: FieldInfo) -> str:
    """Return what `field` may hold, such as `a number greater than 0 and at most 1 [s]`."""
    text = _kind(field.annotation, field.metadata)
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


def _kind(annotation: Any, metadata: list[Any]) -> str:
    origin = get_origin(annotation)
    if origin is Annotated:
        inner, *more = get_args(annotation)
        flat = [m for extra in more for m in (extra.metadata if isinstance(extra, FieldInfo) else [extra])]
        return _kind(inner, flat + metadata)
    if origin is Literal:
        return words(get_args(annotation))
    if origin in (Union, types.UnionType):
        kinds = [_kind(part, metadata) for part in get_args(annotation) if part is not type(None)]
        return " or ".join(kinds)
    if origin is tuple:
        return _list(get_args(annotation))
    if annotation is str:
        shortest = max((getattr(m, "min_length", 0) for m in metadata), default=0)
        return "text in quotes" + (", not empty" if shortest else "")
    if annotation is bool:
        return "true or false"
    if annotation in (int, float):
        name = "whole number" if annotation is int else "number"
        return f"a {name}{_limits(metadata)}"
    return "a table"


def _list(items: tuple[Any, ...]) -> str:
    plural = _kind(items[0], []).replace("a number", "numbers")
    if items[-1] is not Ellipsis:
        return f"a list of {COUNT[len(items)]} {plural}"
    return f"a list of {plural}" if "numbers" in plural else "a list of tables"


def _limits(metadata: list[Any]) -> str:
    found = {name: getattr(m, name) for m in metadata for name, _ in LIMITS if hasattr(m, name)}
    if set(found) == {"ge", "le"}:
        return f" from {_number(found['ge'])} to {_number(found['le'])}"
    parts = [f"{words} {_number(found[name])}" for name, words in LIMITS if name in found]
    return f" {' and '.join(parts)}" if parts else ""


def _number(value: float) -> str:
    return str(int(value)) if float(value).is_integer() and abs(value) < 1e10 else f"{value:g}"
