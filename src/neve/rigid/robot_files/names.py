"""Follow the files that a robot file names, before the engine does: it neither sees circles nor counts."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from neve.scene.errors import SceneError

MOST_GEOMS = 10_000
"""Geoms that a robot may have, in its own file and all that it names, replicas counted."""
DEEPEST = 100
"""Elements inside one another, and files that name one another in a line, at most."""
FOLDERS = ("assetdir", "meshdir", "texturedir")


@dataclass
class Found:
    """Hold what has been counted, and the files on the way to the present one."""

    geoms: float = 0.0
    way: list[Path] = field(default_factory=list)
    steps: int = 0


def follow(path: Path, text: str) -> None:
    """Refuse a robot file that comes back to itself, has too many geoms, or is nested too deeply.

    `text`: the begin of the sentence. Attached models and includes are followed where they are found: beside
    the first file, beside the one that names them, or in the folders that the compiler is told of. A file
    that is not XML is left to the engine.

    Errors: SceneError.
    """
    _follow(path, 1.0, Found(), text)


def _follow(path: Path, times: float, found: Found, text: str) -> None:
    here = path.resolve()
    if here in found.way:
        circle = [*found.way[found.way.index(here) :], here]
        names = " names ".join(json.dumps(file.name, ensure_ascii=False) for file in circle)
        raise SceneError(f"{text} cannot be read as a robot: it goes in a circle: {names}")
    found.steps += 1
    if len(found.way) >= DEEPEST or found.steps > MOST_GEOMS:
        raise SceneError(f"{text} cannot be read as a robot: it names files that name files without end")
    try:
        root = ElementTree.parse(here).getroot()
    except (ElementTree.ParseError, OSError, ValueError):
        return
    found.way.append(here)
    compilers = list(root.iter("compiler"))
    folders = [name for compiler in compilers for key in FOLDERS if (name := compiler.get(key))]
    for element, factor, depth in _elements(root):
        if depth > DEEPEST:
            raise SceneError(
                f"{text} cannot be read as a robot: elements are nested more than {DEEPEST} deep"
            )
        found.geoms += times * factor * (element.tag == "geom")
        if found.geoms > MOST_GEOMS:
            raise SceneError(
                f"{text} cannot be read as a robot: it has more than {MOST_GEOMS:,} geoms, replicas counted"
            )
        if element.tag in ("include", "model") and (name := element.get("file")):
            for file in _candidates(name, found.way, folders):
                _follow(file, times * factor, found, text)
    found.way.pop()


def _elements(root: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, float, int]]:
    """Yield each element of a file, how often `replicate` repeats it, and how deep it lies."""
    left = [(root, 1.0, 0)]
    while left:
        element, times, depth = left.pop()
        yield element, times, depth
        if element.tag == "replicate":
            times *= _count(element.get("count", "1"))
        left.extend((child, times, depth + 1) for child in reversed(element))


def _count(word: str) -> float:
    try:
        return max(float(word), 1.0)
    except ValueError:
        return 1.0


def _candidates(name: str, way: list[Path], folders: list[str]) -> list[Path]:
    """Return the first file that `name` may mean, as a list of one or none."""
    homes = [way[0].parent, way[-1].parent, *(way[0].parent / folder for folder in folders)]
    try:
        return [file for home in homes if (file := home / name).is_file()][:1]
    except (OSError, ValueError):
        return []
