"""Read mesh files: one module for each format; each file is held against its own counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neve.geometry.files.gltf import read_gltf
from neve.geometry.files.obj import read_obj
from neve.geometry.files.ply import read_ply
from neve.geometry.files.stl import read_stl
from neve.geometry.files.wording import Array, Surface, Unreadable
from neve.system import disk

__all__ = ["Surface", "Unreadable", "read"]

COARSE = 1e-3
"""Share of the size of what a file holds, above which a step between numbers in it is told."""


def read(path: Path, notes: list[str]) -> Surface:
    """Return vertices (n, 3) and triangles (m, 3) of all that the file at `path` shows, in its own axes.

    `notes` gets what a user should hear of the file, each as what the file does: "says ...".
    Errors: Unreadable, which says what is wrong in the words of the format; OSError.
    """
    data = disk.read_bytes(path)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        return read_obj(data)
    if suffix == ".stl":
        surface = read_stl(data, notes)
    elif suffix == ".ply":
        surface = read_ply(data)
    else:
        surface = read_gltf(data, path.parent)
    if note := _coarse(surface[0]):
        notes.append(note)
    return surface


def _coarse(vertices: Array) -> str:
    """Say that numbers of single precision are too far apart for what they describe; "" if they are not."""
    if not len(vertices) or not np.isfinite(vertices).all():
        return ""
    step = float(np.spacing(np.float32(np.abs(vertices).max())))
    size = float((vertices.max(axis=0) - vertices.min(axis=0)).max())
    if not step > COARSE * size or (vertices != vertices.astype(np.float32)).any():
        return ""
    return (
        f"has numbers of single precision, {step:.2g} apart so far from its origin, for what is {size:.2g} "
        "large: export it nearer to its origin, or with double precision"
    )
