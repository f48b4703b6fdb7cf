"""Read scenes from TOML files and presets, and write them back."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import ValidationError

from neve.scene.errors import SceneError
from neve.scene.reading import files
from neve.scene.reading.overrides import named, override
from neve.scene.reading.presets import PRESETS, no_such_scene, preset_names, presets, read_toml, require_few
from neve.scene.reading.validation_errors import problems
from neve.scene.schema.scene import Scene
from neve.spelling import hint, nearest
from neve.system.arguments import require


def load(name_or_path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Scene:
    """Return the scene of a preset's name, a TOML file, or a folder that holds scene.toml.

    `overrides` are texts such as "snow.xi=12" or "sources.0.radius=0.3", applied in order.
    A file that the scene names is looked for beside the scene file, or, if an override names it, from the
    current folder.

    Errors: SceneError, one sentence.
    """
    require(
        name_or_path, (str, os.PathLike), "name_or_path", "the name of a preset or the path of a scene file"
    )
    text = os.fspath(name_or_path)
    if text in presets():
        where, path = f"preset {text}", PRESETS / f"{text}.toml"
    else:
        where, path = text, _file(text)
        if path.name != Path(text).name:
            where = os.path.join(text, path.name)
    return scene_from(read_toml(path, where), overrides, where, path.parent)


def scene_from(
    data: Mapping[str, Any],
    overrides: Sequence[str] = (),
    where: str = "scene",
    folder: str | os.PathLike[str] = ".",
) -> Scene:
    """Return the scene that the tables `data` describe; `where` names them in errors, `folder` holds the
    files that they name.

    Errors: SceneError, one sentence.
    """
    require(data, Mapping, "data", "a table of a scene, such as {'sources': [{'shape': 'box'}]}")
    wanted = 'a list of texts, such as ["snow.xi=12"]'
    require(overrides, (list, tuple), "overrides", wanted)
    for text in overrides:
        require(text, str, "overrides", wanted)
    try:
        tables = copy.deepcopy(dict(data))
        files.resolve(tables, Path(folder))
        changed = [(override(tables, text), text) for text in overrides]
        files.resolve(tables, Path.cwd())
    except RecursionError:
        raise SceneError(f"{where}: this is not a scene: its tables are nested too deeply") from None
    require_few({name: len(value) for name, value in tables.items() if isinstance(value, list)}, where)
    try:
        scene = Scene.model_validate(tables)
    except ValidationError as error:
        first, count = problems(error, tables)
        more = f" (and {count - 1} more)" if count > 1 else ""
        sentence = f"{first.sentence}{_whole_table(first.path, tables, changed)}{more}"
        raise SceneError(f"{_origin(first.path, changed, where)}: {sentence}") from None
    for file in files.named_files(scene):
        if problem := files.missing(file):
            raise SceneError(f"{_origin(file.key, changed, where)}: {problem}")
    return scene


def to_toml(scene: Scene, names: Mapping[tuple[str, ...], str] | None = None) -> str:
    """Return `scene` as a complete TOML file, every default spelled out; loading it gives an equal scene.

    `names` are other words at some keys, such as ("sources", "0", "font"), for files that have been copied.
    """
    tables = scene.model_dump(mode="json", exclude_none=True)
    for (name, index, key), word in (names or {}).items():
        tables[name][int(index)][key] = word
    for name in type(scene).model_fields:
        if isinstance(tables.get(name), list):
            tables[name] = [
                {"shape": entry["shape"]} | entry if "shape" in entry else entry for entry in tables[name]
            ]
    return tomli_w.dumps(tables)


def _file(text: str) -> Path:
    try:
        return _scene_file(text)
    except SceneError:
        raise
    except (OSError, RuntimeError, ValueError) as error:  # no such user, a name too long, a closed folder
        reason = (getattr(error, "strerror", None) or str(error)).rstrip(".")
        raise SceneError(
            f"{text}: this cannot be opened as a file: {reason[:1].lower()}{reason[1:]};"
            f" name a .toml file or a preset: {preset_names()}"
        ) from None


def _scene_file(text: str) -> Path:
    path = Path(text).expanduser()
    if path.is_dir():
        if (path / "scene.toml").is_file():
            return path / "scene.toml"
        raise SceneError(
            f"{text} is a folder without scene.toml; name a .toml file or a preset: {preset_names()}"
        )
    if path.is_file():
        return path
    if path.suffix or os.sep in text or "/" in text:
        beside = [p.name for p in path.parent.glob("*.toml")] if path.parent.is_dir() else []
        near = nearest(path.name, beside)
        meant = hint(near and str(path.parent / near))
        raise SceneError(
            f"{text}: there is no such file{meant}; name a .toml file or a preset: {preset_names()}"
        )
    raise SceneError(no_such_scene(text))


def _whole_table(
    path: tuple[str, ...], tables: Mapping[str, Any], changed: list[tuple[tuple[str, ...], str]]
) -> str:
    """Say how to leave out a key of a file's [snow] that does not fit an override's kind or law."""
    asked = {key[1] for key, _ in changed if len(key) == 2 and key[0] == "snow" and key[1] in ("kind", "law")}
    if not asked or len(path) != 2 or path[0] != "snow" or path in [key for key, _ in changed]:
        return ""
    words = ", ".join(f'{key}="{tables["snow"][key]}"' for key in sorted(asked))
    return f"; or replace the whole table with --set 'snow={{{words}}}'"


def _origin(path: tuple[str, ...], changed: list[tuple[tuple[str, ...], str]], where: str) -> str:
    """Return where a problem at `path` comes from: the last override that touched it, or the file."""
    for key, text in reversed(changed):
        shared = min(len(key), len(path))
        if key[:shared] == path[:shared]:
            return named(text)
    return where
