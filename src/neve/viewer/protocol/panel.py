"""The panel of the page, made from the fields of the scene: what there is, in which unit and limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from neve.alter import FIXED
from neve.scene.errors import SceneError
from neve.scene.reading.files import KEYS as FILE_KEYS
from neve.scene.reading.files import OWN, own_files
from neve.scene.reading.load import scene_from
from neve.scene.reading.paths import follow
from neve.scene.schema.allowed import allowed, part, shapes, source, table_of_list, unit
from neve.scene.schema.kinds import Kind, kind_of
from neve.scene.schema.scene import Scene
from neve.scene.schema.snow import used

SECTIONS = ("snow", "world", "numerics", "light", "run")
"""Tables of a scene that the panel shows as a whole; lists of shapes follow, entry by entry."""
LIMITS = ("gt", "ge", "lt", "le")


def panel(scene: Scene) -> list[dict[str, Any]]:
    """Return the sections of the panel: name, title, and fields with path, unit, limits, value and meaning.

    A section whose `parent` is another one lies in it. `can` is what can be done with a whole section: "add"
    makes a table that is left out, or one more entry of a list; "delete" takes it away. `live` says whether a
    change acts at once or when the scene is started anew.
    """
    sections = []
    for name in SECTIONS:
        sections += _sections(name, name, getattr(scene, name), "", "")
    for name in entry_lists():
        for i, entry in enumerate(getattr(scene, name)):
            told = getattr(entry, "shape", "") or Path(getattr(entry, "file", "")).name
            sections += _sections(f"{name}.{i}", f"{name}.{i} {told}".strip(), entry, "", "delete")
    return sections


def lists() -> list[str]:
    """Return the keys of a scene that hold entries with a shape: sources, colliders and others."""
    return [name for name, field in Scene.model_fields.items() if shapes(field.annotation)]


def entry_lists() -> list[str]:
    """Return the keys of a scene that hold entries of any kind: those with a shape, and robots."""
    fields = Scene.model_fields.items()
    return [name for name, field in fields if shapes(field.annotation) or table_of_list(field.annotation)]


def changed(scene: Scene, path: str, value: Any) -> Scene:
    """Return the scene with `value` at `path` ("snow.xi", "colliders.0.mu_c").

    A new kind or law of snow brings its own constants. Errors: SceneError, one sentence.
    """
    tables = scene.model_dump(mode="json", exclude_none=True)
    keys = path.split(".")
    if keys[-1] in FILE_KEYS and not (isinstance(value, str) and value.startswith(OWN)):
        raise SceneError(f"{path}: only files that come with Neve can be named here, such as {OWN}rock")
    if path in ("snow.kind", "snow.law"):
        tables["snow"] = {keys[1]: value}
    else:
        _put(tables, keys, value, path)
    return checked(tables)


def checked(tables: Mapping[str, Any]) -> Scene:
    """Return the scene of `tables`. Errors: SceneError, whose sentence begins with the key."""
    try:
        return scene_from(tables, where="")
    except SceneError as error:
        raise SceneError(str(error).removeprefix(": ")) from None


def is_live(path: str) -> bool:
    """Whether a change of the value at `path` acts on a run that goes on."""
    first, _, rest = path.partition(".")
    if first == "numerics":
        return rest not in FIXED
    return first not in ("sources", "run") or path.split(".")[2:3] == ["snow"]


def _put(tables: dict[str, Any], keys: list[str], value: Any, path: str) -> None:
    place = below(tables, keys[:-1], path, make=True)
    if not isinstance(place, dict):
        raise SceneError(f"{path} is not a single value")
    if value is None:
        place.pop(keys[-1], None)
    else:
        place[keys[-1]] = value


def below(tables: Any, keys: Sequence[str], path: str, make: bool = False) -> Any:
    """Return what lies at `keys` in `tables`; `make` makes the last table if it is left out.

    Errors: SceneError, which says that `path` is not there.
    """
    try:
        above = follow(tables, keys[:-1])
        if make and keys and isinstance(above, dict):
            above.setdefault(keys[-1], {})
        place = follow(tables, keys)
    except KeyError:
        place = None
    if not isinstance(place, dict | list):
        raise SceneError(f"{path} is not in this scene")
    return place


def _sections(path: str, title: str, table: BaseModel, parent: str, can: str) -> list[dict[str, Any]]:
    """Return the section of a table, and after it those of the tables in it."""
    fields, inner = [], []
    for name, field in type(table).model_fields.items():
        if name == "shape" or (path == "snow" and name not in _shown_snow(table)):
            continue
        where, value = f"{path}.{name}", getattr(table, name)
        control = _control(field, value)
        if control is not None:
            fields.append(_field(where, name, field, value) | control)
        elif table_of_list(field.annotation):
            inner.append(_bare(where, name, field.description or "", path, "add"))
            for i, entry in enumerate(value):
                inner += _sections(f"{where}.{i}", f"{name}.{i}", entry, where, "delete")
        elif part(field.annotation) and value is None:
            inner.append(_bare(where, name, field.description or "", path, "add"))
        elif part(field.annotation):
            inner += _sections(where, name, value, path, "delete" if field.default is None else "")
    head = _bare(path, title, _about(type(table)), parent, can)
    return [head | {"fields": fields}, *inner]


def _bare(path: str, title: str, text: str, parent: str, can: str) -> dict[str, Any]:
    return {"path": path, "title": title, "text": text, "parent": parent, "can": can, "fields": []}


def _field(path: str, name: str, field: FieldInfo, value: Any) -> dict[str, Any]:
    return {
        "path": path,
        "name": name,
        "text": field.description or "",
        "unit": unit(field),
        "allowed": allowed(field),
        "source": source(field),
        "default": _plain(field.default),
        "value": _plain(value),
        "live": is_live(path),
    }


def _shown_snow(snow: Any) -> tuple[str, ...]:
    return ("kind", "law", "plasticity", *used(snow.law, snow.plasticity))


def _about(model: type[BaseModel]) -> str:
    return (model.__doc__ or "").strip().split("\n")[0]


def _control(field: FieldInfo, value: Any) -> dict[str, Any] | None:
    """Return what a page needs to draw a control for `field`, None for a table or a list of tables."""
    extra = field.json_schema_extra
    if isinstance(extra, dict) and "suffixes" in extra:
        own = [f"{OWN}{name}" for name in own_files(str(extra["folder"]))] if extra["folder"] else []
        return {"control": "choice", "choices": list(dict.fromkeys([*own, value]))}
    return _widget(kind_of(field.annotation, list(field.metadata)))


def _widget(kind: Kind) -> dict[str, Any] | None:
    if kind.name == "choice":
        return {"control": "choice", "choices": list(kind.choices)}
    if kind.name == "union":
        widgets = [_widget(member) for member in kind.members]
        if len(widgets) == 1 and widgets[0] is not None:
            return {**widgets[0], "optional": kind.optional}
        if None in widgets:
            return None
        return {"control": "text", "optional": kind.optional}  # "auto" or a number
    if kind.name in ("vector", "list"):
        each = _widget(kind.members[0])
        if each is None or each["control"] != "number":
            return None
        shape = {"control": "list"} if kind.name == "list" else {"control": "vector", "count": kind.count}
        return each | shape
    if kind.name in ("integer", "number"):
        return {"control": "number", "whole": kind.name == "integer", **kind.limits}
    return {"control": kind.name} if kind.name in ("switch", "text") else None


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value if isinstance(value, (bool, int, float, str, type(None))) else None
