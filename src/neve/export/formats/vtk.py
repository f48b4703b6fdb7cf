"""VTK's XML files, for ParaView: particles, a grid, solids, and collections that say when each file is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.export.format import NAME, Format, Job, replacing
from neve.export.formats.vtk_grid import write_image
from neve.export.formats.vtk_xml import Appended, at, collection
from neve.export.moment import Moment

GRID, STILL, MOVING = "grid", "solids_still", "solids"

Arrays = Mapping[str, NDArray[Any]]


class Vtk(Format):
    """Write `snow_NNNNNN.vtp`, `grid_NNNNNN.vti`, `solids_NNNNNN.vtp` of what moves, `solids_still.vtp`.

    Files `.pvd` say the time of each. The grid holds density and velocity on a box of cells.

    Particles are points with a vertex each, so that filters can choose among them. The triangles of solids
    know the number of their solid, in the order of solids.csv.
    """

    weighs = True

    def __init__(self, job: Job) -> None:
        super().__init__(job)
        self._still = [(i, surface) for i, surface in self.solids if job.solids[i].motion == "static"]
        self._moving = [(i, surface) for i, surface in self.solids if job.solids[i].motion != "static"]
        self._began = False

    def names(self, frame: int) -> tuple[str, ...]:
        """Return the names of the files of a frame."""
        return tuple(f"{kind}_{frame:06d}.{ending}" for kind, ending in self._kinds())

    def shared_names(self) -> tuple[str, ...]:
        """Return the names of the collections, and of the solids that stand still."""
        found = [f"{kind}.pvd" for kind, _ in self._kinds()]
        return (*found, f"{STILL}.vtp") if self._still else tuple(found)

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
        write_image(self.path(names[1]), moment, self.job.spacing, self.job.axes.scale)
        if self._moving:
            self._write_solids(self.path(names[2]), self._moving, moment)
        if self._still and not self._began:
            self._write_solids(self.path(f"{STILL}.vtp"), self._still, moment)
        self._began = True

    def close(self, times: Mapping[int, float]) -> None:
        """Write the collections."""
        for k, (kind, _) in enumerate(self._kinds()):
            files = {self.names(frame)[k]: time for frame, time in times.items()}
            with replacing(self.path(f"{kind}.pvd")) as file:
                file.write(collection(files).encode())

    def _kinds(self) -> tuple[tuple[str, str], ...]:
        """Return the kinds of files of a frame, and their endings."""
        always = ((NAME, "vtp"), (GRID, "vti"))
        return (*always, (MOVING, "vtp")) if self._moving else always

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
