"""Hurt the folder of a run: flip, cut, delete, swap, double, or lead out of it by a link."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

Random = np.random.Generator


def hurt(rng: Random, kind: str, folder: Path, elsewhere: Path) -> str:
    """Hurt a run `folder` in the way `kind` of HURTS; return which file it was.

    elsewhere: a folder outside of it, which links lead to
    """
    files = sorted(path for path in folder.rglob("*") if path.is_file() and not path.is_symlink())
    path = files[int(rng.integers(len(files)))]
    HURTS[kind](rng, path, folder, elsewhere)
    return str(path.relative_to(folder)) if kind != "link a folder" else "frames"


def _flip(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    data = bytearray(path.read_bytes())
    if data:
        at = int(rng.integers(len(data)))
        data[at] ^= 1 << int(rng.integers(8))
    path.write_bytes(data)


def _cut(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: int(rng.integers(len(data) + 1))])


def _delete(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    path.unlink()


def _swap(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    others = sorted(other for other in path.parent.iterdir() if other.is_file())
    other = others[int(rng.integers(len(others)))]
    one, two = path.read_bytes(), other.read_bytes()
    path.write_bytes(two)
    other.write_bytes(one)


def _double(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data + data)


def _link_file(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    elsewhere.mkdir()
    path.rename(elsewhere / path.name)
    path.symlink_to(elsewhere / path.name)


def _link_folder(rng: Random, path: Path, folder: Path, elsewhere: Path) -> None:
    frames = folder / "frames"
    if frames.is_dir():
        shutil.move(frames, elsewhere)
        os.symlink(elsewhere, frames)


HURTS: dict[str, Callable[[Random, Path, Path, Path], None]] = {
    "flip": _flip,
    "cut": _cut,
    "delete": _delete,
    "swap": _swap,
    "double": _double,
    "link": _link_file,
    "link a folder": _link_folder,
}
"""Ways to hurt a folder, by their words; each gets a file in it."""
