"""Find the files that a scene names: fonts, meshes, height maps, masks. Any list of parts may name some."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from neve.scene.schema.scene import Scene
from neve.scene.values.allowed import words
from neve.scene.values.fields import Part
from neve.spelling import hint, nearest

ASSETS = Path(__file__).parents[2] / "assets"
OWN = "neve:"
"""What begins the name of a file that comes with Neve."""
KEYS = ("font", "file", "mask")
"""The keys that name files."""


@dataclass(frozen=True)
class NamedFile:
    """Hold one file of a scene.

    Attributes:
        key: where in the scene it is named
        name: absolute path, or "neve:NAME"
        suffixes: what it may end in
        folder: folder of such files in Neve's own assets; "" if it has none
    """

    key: tuple[str, ...]
    name: str
    suffixes: tuple[str, ...]
    folder: str

    @property
    def is_own(self) -> bool:
        """Whether it comes with Neve."""
        return bool(self.folder) and self.name.startswith(OWN)


def named_files(scene: Scene) -> Iterator[NamedFile]:
    """Yield every file that the parts of the scene's lists name, in their order."""
    for list_name in type(scene).model_fields:
        value = getattr(scene, list_name)
        for i, part in enumerate(value if isinstance(value, tuple) else ()):
            if isinstance(part, Part):
                yield from _of_part(part, (list_name, str(i)))


def _of_part(part: Part, key: tuple[str, ...]) -> Iterator[NamedFile]:
    for name, field in type(part).model_fields.items():
        extra = field.json_schema_extra
        if isinstance(extra, dict) and "suffixes" in extra and getattr(part, name):
            suffixes: Any = extra["suffixes"]
            yield NamedFile((*key, name), getattr(part, name), tuple(suffixes), str(extra["folder"]))


def own_files(folder: str) -> dict[str, Path]:
    """Return the files of the kind `folder` that come with Neve, by the name after "neve:"."""
    return {path.stem: path for path in sorted((ASSETS / folder).glob("*.*")) if path.suffix != ".md"}


def where(name: str, folder: str) -> Path:
    """Return the path of the file that a scene calls `name`: a path, or a file that comes with Neve.

    Errors: KeyError if Neve has none of that name.
    """
    if folder and name.startswith(OWN):
        return own_files(folder)[name.removeprefix(OWN)]
    return Path(name)


def missing(file: NamedFile) -> str | None:
    """Return the end of the sentence about a file that is not there; None if it is."""
    key, shown = ".".join(file.key), json.dumps(file.name, ensure_ascii=False)
    if file.is_own:
        known = list(own_files(file.folder))
        if file.name.removeprefix(OWN) in known:
            return None
        near = nearest(file.name.removeprefix(OWN), known)
        meant = hint(near and f'"{OWN}{near}"')
        named = words([f"{OWN}{name}" for name in known]) if known else "none"
        return f"{key} = {shown} does not come with Neve{meant}; these do: {named}"
    if _is_file(file.name):
        return None
    return f"{key} = {shown} is not a file; name a {_endings(file.suffixes)} file"


def resolve(tables: dict[str, Any], folder: Path) -> None:
    """Make the names of files in `tables` absolute, seen from `folder`.

    A name that can be no path stays as it is, and is refused after validation.
    """
    for value in tables.values():
        for part in value if isinstance(value, list) else []:
            for key in KEYS if isinstance(part, dict) else ():
                name = part.get(key)
                if isinstance(name, str) and name and not (key == "file" and name.startswith(OWN)):
                    with contextlib.suppress(OSError, RuntimeError, ValueError):
                        part[key] = str((folder / Path(name).expanduser()).resolve())


def _endings(suffixes: tuple[str, ...]) -> str:
    return " or ".join([", ".join(suffixes[:-1]), suffixes[-1]]) if len(suffixes) > 1 else suffixes[0]


def _is_file(path: str) -> bool:
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False
