"""Edit a scene as the page asks: add and delete entries, put solids elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from neve.scene.errors import SceneError
from neve.scene.reading.files import own_files
from neve.scene.reading.paths import follow
from neve.scene.schema.scene import Scene, Source
from neve.scene.schema.tables import shapes, table_of_list
from neve.scene.values.allowed import part
from neve.viewer.protocol.commands import Add, Move
from neve.viewer.tools.change import below, checked
from neve.viewer.tools.panel import entry_lists, lists
from neve.viewer.tools.placing import keys_of


def tables_of(scene: Scene) -> dict[str, Any]:
    """Return the scene as tables, as in a file."""
    return scene.model_dump(mode="json", exclude_none=True)


def added(
    scene: Scene, command: Add, dx: float | None = None, meshes: Mapping[str, Path] | None = None
) -> tuple[Scene, Source | None]:
    """Return the scene with one more entry of a shape at a point [m], and the entry if it is snow.

    The entry has the defaults of its shape; its size fits snow of spacing `dx` [m], the scene's if left out.
    meshes: files that may be named beside those that come with Neve.
    Errors: SceneError.
    """
    known = lists()
    if command.kind not in known:
        raise SceneError(f'a scene has no list "{command.kind}"; there are {", ".join(known)}')
    models = shapes(Scene.model_fields[command.kind].annotation)
    shape, _, file = command.shape.partition(":")
    model = models.get(shape)
    if model is None:
        raise SceneError(f'{command.kind} has no shape "{command.shape}"; there are {", ".join(models)}')
    if file and ("file" not in model.model_fields or file not in {*own_files("meshes"), *(meshes or ())}):
        raise SceneError(f'Neve has no {shape} "{file}" for {command.kind}')
    entry = keys_of(command.shape, command.at, dx or scene.numerics.dx, meshes)
    tables = tables_of(scene)
    tables.setdefault(command.kind, []).append(entry)
    new_scene = checked(tables)
    return new_scene, new_scene.sources[-1] if command.kind == "sources" else None


def deleted(scene: Scene, name: str) -> Scene:
    """Return the scene without an entry of a list or a table in one: "colliders.1", "sources.0.profile".

    Errors: SceneError.
    """
    *above, last = keys = name.split(".")
    tables = tables_of(scene)
    if keys[0] not in entry_lists() or not isinstance(below(tables, keys, name), dict):
        raise SceneError(f"{name} is not in this scene")
    place = below(tables, above, name)
    if isinstance(place, list):
        del place[int(last)]
    else:
        del place[last]
    return checked(tables)


def enlarged(scene: Scene, path: str) -> Scene:
    """Return the scene with the table `path` that was left out, or with one more entry of the list `path`.

    A new entry repeats the last one, a second later. Errors: SceneError.
    """
    keys = path.split(".")
    if keys[0] not in entry_lists() or len(keys) < 3:
        raise SceneError(f"{path} is not in this scene")
    tables = tables_of(scene)
    model = type(below_model(scene, keys[:-1], path))
    field = model.model_fields.get(keys[-1])
    place = below(tables, keys[:-1], path)
    if field is not None and table_of_list(field.annotation):
        entries = place.setdefault(keys[-1], [])
        entries.append({**entries[-1], "t": entries[-1]["t"] + 1.0} if entries else {})
    elif field is not None and part(field.annotation):
        place.setdefault(keys[-1], {})
    else:
        raise SceneError(f"{path} is not a table")
    return checked(tables)


def below_model(scene: Scene, keys: list[str], path: str) -> Any:
    """Return the part of the scene at `keys`, whose last may be a number. Errors: SceneError."""
    try:
        return follow(scene, keys)
    except KeyError:
        raise SceneError(f"{path} is not in this scene") from None


def placed(scene: Scene, move: Move, velocity: Any = (0.0, 0.0, 0.0), spin: Any = (0.0, 0.0, 0.0)) -> Scene:
    """Return the scene with a collider or a body where `move` has it, without keyframes, moving as given.

    velocity [m/s] and spin [rad/s] of a collider count from t = 0, as in a scene. Errors: SceneError.
    """
    if move.name.startswith("robots."):
        raise SceneError(f"{move.name.split('.', 2)[-1]} is part of a robot and cannot be dragged")
    kind, index = place_of(scene, move.name)
    if kind not in ("colliders", "bodies"):
        raise SceneError(f"{move.name} is no solid, and only solids can be dragged; use the grab tool")
    entry = getattr(scene, kind)[index]
    if getattr(entry, "joint", "free") != "free":
        raise SceneError(f"{move.name} hangs on a joint and cannot be dragged")
    change: dict[str, Any] = {entry.place_key: tuple(move.position)}
    if move.rotation is not None and hasattr(entry, "rotation"):
        change["rotation"] = tuple(move.rotation)
    change |= {"velocity": tuple(velocity), "spin": tuple(spin)}
    if hasattr(entry, "keyframes"):
        change["keyframes"] = ()
    fresh = type(entry).model_validate({**dict(entry), **change})
    entries = list(getattr(scene, kind))
    entries[index] = fresh
    return scene.model_copy(update={kind: tuple(entries)})


def place_of(scene: Scene, name: str) -> tuple[str, int]:
    """Return list and number of the entry `name`. Errors: SceneError."""
    kind, _, number = name.partition(".")
    if kind in lists() and number.isascii() and number.isdigit():
        index = int(number)
        if index < len(getattr(scene, kind)):
            return kind, index
    raise SceneError(f"{name} is not in this scene")
