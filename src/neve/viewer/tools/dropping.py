"""Files that a page drops: put together piece by piece, kept in the session's folder, and checked."""

from __future__ import annotations

import base64
import binascii
import contextlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from neve.io.atomic import write_bytes, writing
from neve.scene.errors import SceneError
from neve.scene.reading.files import KEYS, OWN
from neve.scene.reading.load import scene_from
from neve.scene.reading.presets import read_toml
from neve.scene.schema.file_shapes import MAPS
from neve.scene.schema.scene import Scene
from neve.system import disk
from neve.viewer.protocol.commands import Piece
from neve.viewer.protocol.messages import Addable, vector
from neve.viewer.tools.placing import half_of_file

FOLDER = "dropped"
"""Folder of dropped files in that of the session."""

MESHES = (".ply", ".obj", ".stl", ".glb")
"""Endings of meshes that are one file; a .gltf names others."""

MOST_DROPPED = 24 * 2**20
"""Bytes of a file that may be dropped."""


class Upload:
    """Put the pieces of one file together, which come in order from one page."""

    def __init__(self) -> None:
        self._owner: object = None
        self._name, self._of = "", 0
        self._content = bytearray()

    def take(self, owner: object, piece: Piece) -> bytes | None:
        """Return the whole file after its last piece, else None.

        Errors: SceneError for a piece that does not follow the one before; then the file is dropped.
        """
        if piece.at == 0:
            self._owner, self._name, self._of, self._content = owner, piece.name, piece.of, bytearray()
        try:
            data = base64.b64decode(piece.data, validate=True)
        except (binascii.Error, ValueError):
            data = b""
        follows = owner is self._owner and (piece.name, piece.of, piece.at) == (
            self._name, self._of, len(self._content),
        )  # fmt: skip
        if not follows or not data or len(self._content) + len(data) > self._of:
            self._owner, self._content = None, bytearray()
            raise SceneError(f"{piece.name} did not arrive whole: drop it again")
        self._content += data
        if len(self._content) < self._of:
            return None
        whole, self._content, self._owner = bytes(self._content), bytearray(), None
        return whole


def kept(folder: Path, name: str, content: bytes) -> Path:
    """Write a dropped file into the session's folder under a plain name of its own; return its path.

    Errors: SceneError for an ending that nothing can be made of; RunError if the disk refuses.
    """
    stem, dot, ending = name.replace("\\", "/").rpartition("/")[2].rpartition(".")
    ending = f".{ending.lower()}" if dot else ""
    if ending != ".toml" and ending not in (*MESHES, *MAPS):
        raise SceneError(
            f"{name}: drop a scene (.toml), a mesh ({', '.join(MESHES)}) or a height map ({', '.join(MAPS)})"
        )
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", stem)[:40] or "file"
    place = folder / FOLDER
    with writing(place):
        disk.make_folder(folder)
        disk.make_folder(place)
    path, number = place / f"{plain}{ending}", 1
    while path.exists():
        number += 1
        path = place / f"{plain}-{number}{ending}"
    write_bytes(path, content)
    return path


@contextlib.contextmanager
def refused_by_name(path: Path, name: str) -> Iterator[None]:
    """Let a refusal speak of the file by the name that was dropped; what is refused is not kept."""
    try:
        yield
    except SceneError as error:
        disk.remove(path)
        text = str(error).removeprefix(f"{path}.file = ")
        for kept_as in (f'"{path}"', str(path), path.name):
            text = text.replace(kept_as, name)
        raise SceneError(text) from error


def scene_of(path: Path, meshes: Mapping[str, Path]) -> Scene:
    """Return the scene in a dropped file. Of other files it may name those that come with Neve, or `meshes`.

    Errors: SceneError, one sentence.
    """
    tables = read_toml(path, path.name)
    _use_dropped(tables, meshes, path.name)
    return scene_from(tables, where=path.name)


def _use_dropped(part: Any, meshes: Mapping[str, Path], where: str) -> None:
    """Put the paths of dropped files where their names stand; refuse all others. Errors: SceneError."""
    items = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
    for key, value in items:
        if key not in KEYS or not isinstance(value, str) or value.startswith(OWN) or not value:
            _use_dropped(value, meshes, where)
        elif (name := value.replace("\\", "/").rpartition("/")[2]) in meshes:
            part[key] = str(meshes[name])
        else:
            raise SceneError(
                f'{where}: {key} = "{value[:80]}" is a file that the page does not have: '
                f"drop it first, or name one that comes with Neve, such as {OWN}rock"
            )


def offered(path: Path, dx: float) -> Addable:
    """Return what can be added of a dropped mesh or height map, in snow of the spacing `dx` [m].

    Errors: SceneError: it cannot be read.
    """
    shape = f"{'terrain' if path.suffix in MAPS else 'mesh'}:{path.name}"
    return {"shape": shape, "half": vector(half_of_file(shape, str(path), dx))}
