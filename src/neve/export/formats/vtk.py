"""VTK's XML files, for ParaView: particles, solids, and collections that say at what time each file is.

The format is that of "VTK XML file formats" (docs.vtk.org): arrays lie in binary behind the description.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from neve.export.format import NAME, Format, Job, replacing
from neve.export.moment import Moment
from neve.export.solids import surfaces

STILL, MOVING = "solids_still", "solids"
CHUNK = 2**22
"""Bytes that are written at once."""
_TYPES = {"f4": "Float32", "f8": "Float64", "u1": "UInt8", "u2": "UInt16", "u4": "UInt32", "u8": "UInt64"}
_TYPES |= {"i4": "Int32", "i8": "Int64"}

Arrays = Mapping[str, NDArray[Any]]


class Vtk(Format):
    """Write `snow_NNNNNN.vtp`, `solids_NNNNNN.vtp` of what moves, `solids_still.vtp`, and `.pvd` files.

    Particles are points with a vertex each, so that filters can choose among them. The triangles of solids
    know the number of their solid, in the order of solids.csv.
    """

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        shown = surfaces(job.solids, job.axes.scale)
        self._still = [(i, surface) for i, surface in shown if job.solids[i].motion == "static"]
        self._moving = [(i, surface) for i, surface in shown if job.solids[i].motion != "static"]
        self._began = False

    def names(self, frame: int) -> tuple[str, ...]:
        """Return the names of the files of a frame."""
        kinds = (NAME, MOVING) if self._moving else (NAME,)
        return tuple(f"{kind}_{frame:06d}.vtp" for kind in kinds)

    def shared_names(self) -> tuple[str, ...]:
        """Return the names of the collections, and of the solids that stand still."""
        found = [f"{NAME}.pvd"]
        found += [f"{MOVING}.pvd"] if self._moving else []
        found += [f"{STILL}.vtp"] if self._still else []
        return tuple(found)

    def write(self, moment: Moment) -> None:
        """Write the files of a frame."""
        names = self.names(moment.frame)
        count = len(moment.x)
        kind = np.int32 if count < 2**31 else np.int64
        vertices = {
            "connectivity": np.arange(count, dtype=kind),
            "offsets": np.arange(1, count + 1, dtype=kind),
        }
        write_poly(self.path(names[0]), moment.time, moment.x, {"Verts": vertices}, moment.fields, {})
        if self._moving:
            self._write_solids(self.path(names[1]), self._moving, moment)
        if self._still and not self._began:
            self._write_solids(self.path(f"{STILL}.vtp"), self._still, moment)
        self._began = True

    def close(self, times: Mapping[int, float]) -> None:
        """Write the collections."""
        for k, kind in enumerate((NAME, MOVING) if self._moving else (NAME,)):
            files = {self.names(frame)[k]: time for frame, time in times.items()}
            with replacing(self.path(f"{kind}.pvd")) as file:
                file.write(collection(files).encode())

    def _write_solids(self, path: Path, shown: Sequence[Any], moment: Moment) -> None:
        places, corners, which, first = [], [], [], 0
        for i, surface in shown:
            pose = moment.poses[i]
            places.append(surface.vertices @ pose[:3, :3].T + pose[:3, 3])
            corners.append(surface.faces + np.int32(first))
            which.append(np.full(len(surface.faces), i, np.int32))
            first += len(surface.vertices)
        faces = np.concatenate(corners)
        polys = {
            "connectivity": np.ascontiguousarray(faces).reshape(-1),
            "offsets": np.arange(3, 3 * len(faces) + 1, 3, dtype=np.int32),
        }
        x = np.concatenate(places).astype(np.float32)
        write_poly(path, moment.time, x, {"Polys": polys}, {}, {"solid": np.concatenate(which)})


def write_poly(
    path: Path,
    time: float,
    x: NDArray[Any],
    cells: Mapping[str, Arrays],
    point_data: Arrays,
    cell_data: Arrays,
) -> None:
    """Write a .vtp file: points x (n, 3), "Verts" or "Polys" with their arrays, data. Errors: RunError."""
    body = Appended()
    count = {name: len(arrays["offsets"]) for name, arrays in cells.items()}
    counts = " ".join(
        f'NumberOf{name}="{count.get(name, 0)}"' for name in ("Verts", "Lines", "Strips", "Polys")
    )
    piece = [
        f'<Piece NumberOfPoints="{len(x)}" {counts}>',
        "<PointData>",
        *(body.add(name, values) for name, values in point_data.items()),
        "</PointData>",
        "<CellData>",
        *(body.add(name, values) for name, values in cell_data.items()),
        "</CellData>",
        f"<Points>{body.add('Points', x)}</Points>",
    ]
    for name, arrays in cells.items():
        inner = "".join(body.add(key, values) for key, values in arrays.items())
        piece.append(f"<{name}>{inner}</{name}>")
    with replacing(path) as file:
        body.write(file, "PolyData", "", [at(time), *piece, "</Piece>"])


def at(time: float) -> str:
    """Return the element that tells ParaView the time [s] of a file."""
    kind = 'type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii"'
    return f"<FieldData><DataArray {kind}>{time!r}</DataArray></FieldData>"


def collection(files: Mapping[str, float]) -> str:
    """Return the content of a .pvd file: times [s] of files, by name."""
    rows = [f'<DataSet timestep="{time!r}" part="0" file={quoteattr(name)}/>' for name, time in files.items()]
    head = '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">'
    return "\n".join(['<?xml version="1.0"?>', head, "<Collection>", *rows, "</Collection>", "</VTKFile>\n"])


class Appended:
    """Collect arrays, which come behind the description in binary, each after its length in 8 bytes."""

    def __init__(self) -> None:
        self._arrays: list[NDArray[Any]] = []
        self._end = 0

    def add(self, name: str, values: NDArray[Any]) -> str:
        """Take an array, a row for each tuple; return the element that describes it."""
        self._arrays.append(values)
        kind = values.dtype.str[1:]
        shape = f'NumberOfComponents="{int(np.prod(values.shape[1:], dtype=int))}"'
        element = f'<DataArray type="{_TYPES[kind]}" Name={quoteattr(name)} {shape} format="appended"'
        element += f' offset="{self._end}"/>'
        self._end += 8 + values.nbytes
        return element

    def write(self, file: BinaryIO, type: str, attributes: str, inner: Sequence[str]) -> None:
        """Write a whole file of a data set of this type, described by its attributes and inner elements."""
        head = f'<VTKFile type="{type}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
        lines = ['<?xml version="1.0"?>', head, f"<{type}{attributes}>", *inner, f"</{type}>"]
        file.write("\n".join([*lines, '<AppendedData encoding="raw">', "_"]).encode())
        for values in self._arrays:
            file.write(np.uint64(values.nbytes).tobytes())
            step = max(1, CHUNK // max(1, values.nbytes // max(1, len(values))))
            for first in range(0, len(values), step):
                file.write(np.ascontiguousarray(values[first : first + step]).tobytes())
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
