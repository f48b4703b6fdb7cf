"""Find the tables that a scene is made of: its lists of shapes, its parts, their defaults."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, get_args, get_origin

from pydantic import BaseModel

from neve.scene.schema.outputs import OpenList
from neve.scene.schema.roles import Role, forms
from neve.scene.values.allowed import part


def shapes(annotation: Any) -> dict[str, type[Role]]:
    """Return the models of a list of shapes by the word that picks them; nothing for any other annotation."""
    if get_origin(annotation) is not tuple:
        return {}
    item = get_args(annotation)[0]
    role = get_args(item)[0] if get_origin(item) is Annotated else None
    return forms(role) if isinstance(role, type) and issubclass(role, Role) else {}


def entry_models(annotation: Any) -> tuple[str, Mapping[str, type[BaseModel]]]:
    """Return the key that picks the model of a list's entry, "shape" or "kind", and the models by its word.

    There are no models for an annotation that is not such a list.
    """
    item = get_args(annotation)[0] if get_origin(annotation) is tuple else None
    for mark in getattr(item, "__metadata__", ()):
        if isinstance(mark, OpenList):
            return mark.tag, mark.models()
    return "shape", shapes(annotation)


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
