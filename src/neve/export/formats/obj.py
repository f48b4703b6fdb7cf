"""OBJ: the surface of the snow and the solids as meshes, a file for each frame, in text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from neve.export.format import NAME, Format, replacing
from neve.export.moment import Moment

CHUNK = 2**15
"""Lines that are put together at once."""


class Obj(Format):
    """Write `snow_NNNNNN.obj`: the object `snow` with normals, then an object for each solid.

    The name of an object is that of its solid, with _ for all but letters and digits.
    """

    ending = "obj"
    up = "y"
    takes_fields = False

    def write(self, moment: Moment) -> None:
        """Write the file of a frame."""
        from neve.surface.mesh import snow_surface

        snow = snow_surface(moment.x, self.job.spacing)
        with replacing(self.path(self.names(moment.frame)[0])) as file:
            file.write(f"# Neve, {moment.time!r} s\n".encode())
            _write(file, NAME, snow.vertices, snow.faces, 1, snow.normals)
            first = 1 + len(snow.vertices)
            for i, surface in self.solids:
                pose = moment.poses[i]
                places = surface.vertices @ pose[:3, :3].T + pose[:3, 3]
                _write(file, surface.word, places, surface.faces, first)
                first += len(places)


def _write(
    file: BinaryIO,
    name: str,
    vertices: NDArray[Any],
    faces: NDArray[Any],
    first: int,
    normals: NDArray[Any] | None = None,
) -> None:
    """Write an object; `first` is the number of its first vertex, counted from 1 through the file."""
    file.write(f"o {name}\n".encode())
    for lines in _lines("v %.7g %.7g %.7g\n", vertices):
        file.write(lines)
    if normals is None:
        form, corners = "f %d %d %d\n", faces + first
    else:
        for lines in _lines("vn %.4f %.4f %.4f\n", normals):
            file.write(lines)
        form, corners = "f %d//%d %d//%d %d//%d\n", np.repeat(faces + first, 2, axis=1)
    for lines in _lines(form, corners):
        file.write(lines)


def _lines(form: str, rows: NDArray[Any]) -> Iterator[bytes]:
    for start in range(0, len(rows), CHUNK):
        some = rows[start : start + CHUNK]
        yield (form * len(some) % tuple(some.ravel().tolist())).encode()
