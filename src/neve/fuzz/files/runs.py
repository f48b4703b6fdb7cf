"""Damage one file of a small run, or the arrays of its checkpoint, and resume the run."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from neve.fuzz.files.mutate import Generator, damaged
from neve.io.npz import write_npz

FILES = ("run.json", "scene.toml", "log.csv", "solids.csv", "checkpoint")
"""The files of the run that are damaged, one at a time."""
STATE = "state.npz"
"""The kind of a checkpoint whose bytes and checksums are right and whose arrays are not."""
FRAME = "frames/000000.npz"
SCENE: dict[str, Any] = {
    "sources": [
        {"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0.0, 0.0, 0.2]},
        {"shape": "sphere", "radius": 0.15, "center": [0.0, 0.0, 0.6], "snow": {"law": "cam_clay", "M": 1.0}},
    ],
    "numerics": {"dx": 0.1, "transfer": "polypic"},
    "colliders": [
        {"shape": "plane", "mode": "slip"},
        {"shape": "sphere", "center": [3.0, 0.0, 1.0], "velocity": [1.0, 0.0, 0.0]},
    ],
    "bodies": [{"shape": "box", "size": [0.2, 0.2, 0.2], "center": [0.0, 1.0, 1.0]}],
    "run": {"film": False},
}
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, -1.0)
WHOLES = (0, 1, 2, -1, 2**16 - 1, 2**31, 2**32 - 1)

Array = np.ndarray[Any, Any]


@lru_cache
def run_files() -> dict[str, bytes]:
    """Return every file of a run of two frames, by its path in the folder."""
    from neve.run import run_scene
    from neve.scene.reading.load import scene_from

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "run"
        run_scene(scene_from(SCENE), folder, threads=1, frames=1, quiet=True)
        files = [path for path in folder.rglob("*") if path.is_file()]
        return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def resume_with(name: str, path: Path) -> None:
    """Resume the run with the content of `path` in the place of its file `name`."""
    from neve.run import run_scene
    from neve.scene.reading.load import load, scene_from

    folder = path.with_name(f"{path.name.partition('.')[0]}.run")
    try:
        for each, content in run_files().items():
            (folder / each).parent.mkdir(parents=True, exist_ok=True)
            (folder / each).write_bytes(content)
        (folder / name).write_bytes(path.read_bytes())
        scene = load(folder) if name == "scene.toml" else scene_from(SCENE)
        run_scene(scene, folder, threads=1, frames=2, resume=True, quiet=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def readers() -> dict[str, Callable[[Path], object]]:
    """Return how each kind of file is read, each kind named after the ending of its files."""
    found = {name: partial(resume_with, name) for name in FILES}
    return found | {STATE: partial(resume_with, "checkpoint"), "frame.npz": _frame}


def _frame(path: Path) -> None:
    from neve.io.frames import frame_path, read_frame

    number = int(path.name.partition(".")[0])
    path.rename(frame_path(path.parent, number))
    read_frame(path.parent, number)


def damaged_file(kind: str, content: bytes, other: bytes, rng: Generator) -> bytes:
    """Return the content of a file of this kind after damages drawn from `rng`."""
    return _damaged_arrays(content, rng) if kind == STATE else damaged(content, other, rng)


def _damaged_arrays(content: bytes, rng: Generator) -> bytes:
    """Return the archive `content` with one to three arrays that are not what they should be."""
    with np.load(io.BytesIO(content)) as archive:
        arrays = dict(archive)
    names = [name for name in arrays if name.startswith("state.") or name == "frame"]
    for _ in range(int(rng.integers(1, 4))):
        name = names[rng.integers(len(names))]
        if name in arrays:
            WAYS[rng.integers(len(WAYS))](arrays, name, names, rng)
    file = io.BytesIO()
    write_npz(file, arrays)
    return file.getvalue()


Arrays = dict[str, Array]


def _value(arrays: Arrays, name: str, names: list[str], rng: Generator) -> None:
    """Put a number that does not belong there."""
    array = arrays[name].copy()
    if array.size and array.dtype.kind in "fiu":
        values = NUMBERS if array.dtype.kind == "f" else WHOLES
        with np.errstate(all="ignore"):
            number = np.array(values[rng.integers(len(values))]).astype(array.dtype)
        array.reshape(-1)[rng.integers(array.size)] = number
    arrays[name] = array


def _kind(arrays: Arrays, name: str, names: list[str], rng: Generator) -> None:
    """Turn all numbers into others, or into words."""
    dtype = str(rng.choice(("f2", "f4", "f8", "i8", "u1", "c16", "U9", "?", "M8[s]")))
    if arrays[name].dtype.kind in "fiu":
        with np.errstate(all="ignore"):
            whole = np.nan_to_num(arrays[name]).astype("i8") if dtype.startswith("M8") else arrays[name]
            arrays[name] = whole.astype(dtype)


def _shape(arrays: Arrays, name: str, names: list[str], rng: Generator) -> None:
    """Cut, double, empty or bend an array."""
    flat = arrays[name].reshape(-1)
    cut = flat[: rng.integers(flat.size + 1)]
    arrays[name] = (cut, np.concatenate([flat, flat]), arrays[name][None], flat[:0], flat)[rng.integers(5)]


def _rows(arrays: Arrays, name: str, names: list[str], rng: Generator) -> None:
    """Put rows of all arrays of particles, or of one, in another order, or one in the place of another."""
    array = arrays[name]
    if array.ndim and len(array):
        order = rng.permutation(len(array)) if rng.random() < 0.5 else np.zeros(len(array), int)
        arrays[name] = array[order]


def _another(arrays: Arrays, name: str, names: list[str], rng: Generator) -> None:
    """Put an array in the place of another, or leave it out."""
    if rng.random() < 0.3:
        del arrays[name]
    elif (other := names[rng.integers(len(names))]) in arrays:
        arrays[name] = arrays[other]


WAYS = (_value, _value, _value, _kind, _shape, _rows, _another)
