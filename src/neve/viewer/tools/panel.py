"""The panel of the page, made from the fields of the scene: what there is, in which unit and limits."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any, Literal, cast

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from neve.scene.reading.files import OWN, own_files
from neve.scene.reading.paths import follow
from neve.scene.schema.material import used
from neve.scene.schema.scene import Scene
from neve.scene.schema.tables import shapes, table_of_list
from neve.scene.values.allowed import allowed, part, source, unit
from neve.scene.values.kinds import Kind, kind_of
from neve.viewer.protocol.messages import Control, Field, Section
from neve.viewer.tools.change import is_live

SECTIONS = ("snow", "world", "numerics", "light", "run")
"""Tables of a scene that the panel shows as a whole; lists of shapes follow, entry by entry."""
LIMITS = ("gt", "ge", "lt", "le")
Can = Literal["", "add", "delete"]


def panel(scene: Scene, begun: Scene | None = None) -> list[Section]:
    """Return the sections of the panel; one that lies in another comes after it.

    begun: the scene with which the run began; a field that only a beginning takes says what it had there.
    """
    sections: list[Section] = []
    for name in SECTIONS:
        sections += _sections(scene, name, name, getattr(scene, name), "", "")
    for name in entry_lists():
        for i, entry in enumerate(getattr(scene, name)):
            kind = getattr(entry, "shape", "") or Path(getattr(entry, "file", "")).name
            sections += _sections(scene, f"{name}.{i}", f"{name}.{i} {kind}".strip(), entry, "", "delete")
    for field in (
        field for section in sections for field in section["fields"] if begun and not field["live"]
    ):
        with contextlib.suppress(KeyError):  # an entry that was not there yet
            had = _plain(follow(begun, field["path"].split(".")))
            if had != field["value"]:
                field["now"] = had
    return sections


def lists() -> list[str]:
    """Return the keys of a scene that hold entries with a shape: sources, colliders and others."""
    return [name for name, field in Scene.model_fields.items() if shapes(field.annotation)]


def entry_lists() -> list[str]:
    """Return the keys of a scene that hold entries of any kind: those with a shape, and robots."""
    fields = Scene.model_fields.items()
    return [name for name, field in fields if shapes(field.annotation) or table_of_list(field.annotation)]


def _sections(scene: Scene, path: str, title: str, table: BaseModel, parent: str, can: Can) -> list[Section]:
    """Return the section of a table, and after it those of the tables in it."""
    fields: list[Field] = []
    inner: list[Section] = []
    for name, field in type(table).model_fields.items():
        if name == "shape" or (path == "snow" and name not in _shown_snow(table)):
            continue
        where, value = f"{path}.{name}", getattr(table, name)
        control = _control(field, value)
        if control is not None:
            fields.append(_field(scene, where, name, field, value, control))
        elif table_of_list(field.annotation):
            inner.append(_bare(where, name, field.description or "", path, "add"))
            for i, entry in enumerate(value):
                inner += _sections(scene, f"{where}.{i}", f"{name}.{i}", entry, where, "delete")
        elif part(field.annotation) and value is None:
            inner.append(_bare(where, name, field.description or "", path, "add"))
        elif part(field.annotation):
            inner += _sections(scene, where, name, value, path, "delete" if field.default is None else "")
    head = _bare(path, title, _about(type(table)), parent, can)
    head["fields"] = fields
    return [head, *inner]


def _bare(path: str, title: str, text: str, parent: str, can: Can) -> Section:
    return {"path": path, "title": title, "text": text, "parent": parent, "can": can, "fields": []}


def _field(scene: Scene, path: str, name: str, field: FieldInfo, value: Any, control: Control) -> Field:
    return {
        "path": path,
        "name": name,
        "text": field.description or "",
        "unit": unit(field),
        "allowed": allowed(field),
        "source": source(field),
        "default": _plain(field.default),
        "value": _plain(value),
        "live": is_live(scene, path),
        **control,  # type: ignore[typeddict-item]
    }


def _shown_snow(snow: Any) -> tuple[str, ...]:
    return ("kind", "law", "plasticity", *used(snow.law, snow.plasticity))


def _about(model: type[BaseModel]) -> str:
    return (model.__doc__ or "").strip().split("\n")[0]


def _control(field: FieldInfo, value: Any) -> Control | None:
    """Return what a page needs to draw a control for `field`, None for a table or a list of tables."""
    extra = field.json_schema_extra
    if isinstance(extra, dict) and "suffixes" in extra:
        own = [f"{OWN}{name}" for name in own_files(str(extra["folder"]))] if extra["folder"] else [""]
        return {"control": "choice", "choices": list(dict.fromkeys([*own, value]))}
    return _widget(kind_of(field.annotation, list(field.metadata)))


def _widget(kind: Kind) -> Control | None:
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
        return cast(Control, each | shape)
    if kind.name in ("integer", "number"):
        return cast(Control, {"control": "number", "whole": kind.name == "integer", **kind.limits})
    return cast(Control, {"control": kind.name}) if kind.name in ("switch", "text") else None


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value if isinstance(value, (bool, int, float, str, type(None))) else None
