"""The files that a scene names, kept with its run: a run folder is whole, wherever it is moved."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote

from neve.io.atomic import write_bytes, writing
from neve.io.errors import cannot_read
from neve.io.links import refuse_link
from neve.scene.reading.files import NamedFile, named_files
from neve.scene.reading.load import to_toml
from neve.scene.schema.bodies import ROBOTS
from neve.scene.schema.scene import Scene
from neve.system import disk

FOLDER = "assets"
DIGITS = 12
"""Hexadecimal digits of the SHA-256 of its content in the name of a kept file."""
LONGEST = 64
"""Characters of its own name in the name of a kept file."""
_KEPT = re.compile(rf"(?:.*/)?[^/]*-([0-9a-f]{{{DIGITS}}})(?:\.[^/.]*|/.*)?", re.DOTALL)


@dataclass(frozen=True)
class Asset:
    """Hold one file that a scene names, with the files that it names in turn.

    Attributes:
        key: where the scene names it
        name: what the scene of the run calls it, relative to the run folder
        files: from where to where, relative to the run folder
    """

    key: tuple[str, ...]
    name: str
    files: tuple[tuple[Path, str], ...]


def assets_of(scene: Scene) -> list[Asset]:
    """Return the files that `scene` names, but those that come with Neve; their content is in their names.

    Errors: RunError for a file that cannot be read.
    """
    once: dict[str, Asset] = {}
    found = []
    for file in named_files(scene):
        if not file.is_own:
            known = once.get(file.name) or once.setdefault(file.name, _asset(file))
            found.append(replace(known, key=file.key))
    return found


def portable(scene: Scene, assets: Sequence[Asset]) -> str:
    """Return `scene` as the TOML of its run folder, where every file is called by its name in there."""
    return to_toml(scene, {asset.key: asset.name for asset in assets})


def keep_assets(folder: Path, assets: Sequence[Asset]) -> None:
    """Copy `assets` into the run `folder`, each file whole or not at all; and drop those of an earlier run.

    Errors: RunError if a file cannot be read or written.
    """
    wanted: dict[str, Path] = {name: source for asset in assets for source, name in asset.files}
    for name, source in wanted.items():
        refuse_link(folder, folder / name, but_last=True)
        _copy(source, folder / name)
    place = folder / FOLDER
    refuse_link(folder, place)
    if not place.is_dir():
        return
    first = {Path(name).parts[1] for name in wanted}
    with writing(place):
        disk.sweep(place)
        for path in place.iterdir():
            if _KEPT.fullmatch(path.name) and path.name not in first:
                disk.remove_tree(path)
    disk.remove_if_empty(place)  # other files in it stay, and the folder with them


def same_content(before: object, now: object) -> bool:
    """Tell whether two names of kept files stand for the same content."""
    hashes = [_KEPT.fullmatch(name) for name in (before, now) if isinstance(name, str)]
    return len(hashes) == 2 and all(hashes) and len({match[1] for match in hashes if match}) == 1


def _asset(file: NamedFile) -> Asset:
    path = Path(file.name)
    paths = [path, *companions(path)]
    root = Path(os.path.commonpath([p.parent for p in paths]))
    digest = hashlib.sha256()
    for p in paths:
        content = _bytes(p)
        if len(paths) > 1:
            digest.update(f"{p.relative_to(root).as_posix()}\0{len(content)}\0".encode())
        digest.update(content)
    mark = digest.hexdigest()[:DIGITS]
    if len(paths) == 1:
        stem = path.stem if path.stem.endswith(f"-{mark}") else f"{path.stem[:LONGEST]}-{mark}"
        name = f"{FOLDER}/{stem}{path.suffix}"
        return Asset(file.key, name, ((path, name),))
    home = f"{FOLDER}/{path.stem[:LONGEST]}-{mark}"
    files = tuple((p, f"{home}/{p.relative_to(root).as_posix()}") for p in paths)
    return Asset(file.key, files[0][1], files)


def companions(path: Path) -> list[Path]:
    """Return the files that the file `path` names in turn and that are there, absolute, each once."""
    if path.suffix.lower() in ROBOTS:
        from neve.rigid.robot_files.helper import files_of  # needs the rigid-body engine

        names: Sequence[str | Path] = files_of(path)
    elif path.suffix.lower() == ".gltf":
        names = _of_gltf(_bytes(path))
    elif path.suffix.lower() == ".asc":
        names = [path.with_suffix(".prj").name]  # its coordinate system
    else:
        return []
    found = (Path(os.path.normpath(path.parent / name)) for name in names)
    return [p for p in dict.fromkeys(found) if p != path and p.is_file()]


def _of_gltf(content: bytes) -> list[str]:
    """Return the buffers of a glTF file (Khronos glTF 2.0, section 3.6.1); pictures are not read."""
    try:
        buffers = json.loads(content).get("buffers", [])
        uris = [buffer["uri"] for buffer in buffers if "uri" in buffer]
    except (ValueError, AttributeError, TypeError, KeyError):
        return []
    return [unquote(uri) for uri in uris if isinstance(uri, str) and not uri.startswith("data:")]


def _bytes(path: Path) -> bytes:
    try:
        return disk.read_bytes(path)
    except OSError as error:
        raise cannot_read(path, error) from error


def _copy(source: Path, target: Path) -> None:
    content = _bytes(source)
    with writing(target):
        disk.make_folder(target.parent)
        if target.is_file() and not target.is_symlink() and target.read_bytes() == content:
            return
    write_bytes(target, content)
