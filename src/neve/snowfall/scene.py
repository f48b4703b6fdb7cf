"""What snow falls on in a scene, and the snow that lies before its run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.geometry.mesh import read_mesh
from neve.geometry.pose import Pose, rotation_matrix
from neve.geometry.triangles import Triangles
from neve.reproducible import product
from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Layer, Mesh, Text
from neve.scene.schema.scene import Scene, Source
from neve.scene.schema.snow_kinds import SNOWS
from neve.scene.schema.snowfall import Lying, Snowfall
from neve.snowfall.cover import Cover, Raster, let_fall
from neve.snowfall.files import cover_of, read_lying
from neve.snowfall.kept import fallen_once
from neve.snowfall.resting import Resting, resting_of
from neve.snowfall.skin import skin
from neve.snowfall.surroundings import Piece, Surroundings, joined, piece_of_solid, piece_of_triangles

Placed = Sequence[tuple[Solid, Pose]]
"""Solids, and where they are at the start."""


class Falls:
    """Hold the snow of a scene's snowfalls as it lies when the run begins, each counted once."""

    def __init__(self, scene: Scene, placed: Placed) -> None:
        self._scene, self._placed = scene, placed
        self._snows: dict[int, Cover | Resting] = {}
        self._pieces: list[Piece] = []

    def snow(self, index: int) -> Cover | Resting:
        """Return the snow of the source number `index`, a snowfall or snow from a file.

        A snowfall falls on the solids and on all sources before it, one after the other.

        Errors: SceneError for a source before it whose surface is not known, a mesh that cannot be used, or
        a file that holds no snow.
        """
        if index not in self._snows:
            source = self._scene.sources[index]
            if isinstance(source, Lying):
                self._snows[index] = lying(Path(source.file), f"sources.{index}.file")
            else:
                self._snows[index] = fallen_once(*self._given(index))
        return self._snows[index]

    def fallen(
        self,
        index: int,
        told: Callable[[int, int], None] = lambda done, of: None,
        seen: Callable[[NDArray[np.float64]], None] = lambda depth: None,
    ) -> Cover:
        """Let the snowfall of the source number `index` fall; `told`, `seen`: as of `let_fall`."""
        return let_fall(*self._given(index), told, seen)

    def _given(self, index: int) -> tuple[Snowfall, Surroundings, Raster]:
        """Return what falls as the source number `index`, and on what. Errors: SceneError."""
        source = self._scene.sources[index]
        if not isinstance(source, Snowfall):
            raise TypeError(f"sources.{index} is no snowfall")
        fall = source.of_kind(SNOWS[self._scene.snow_of(source).kind])
        before = self._before(index)
        cell = fall.cell or self._scene.numerics.spacing
        raster = Raster.over(fall.center, fall.size, cell)
        require_few(raster, f"sources.{index}.cell", cell)
        return fall, around(fall, self._placed, before), raster

    def _before(self, index: int) -> list[Piece]:
        """Return the surfaces of the sources before number `index`."""
        while len(self._pieces) < index:
            i = len(self._pieces)
            source, name = self._scene.sources[i], f"sources.{i}"
            if isinstance(source, (Snowfall, Lying)):
                self._pieces.append(piece_of_triangles(name, surface_of(self.snow(i))))
            else:
                self._pieces.append(piece_of_source(source, name))
        return self._pieces[:index]


def lying(path: Path, key: str) -> Cover | Resting:
    """Return the snow of a file of lying snow, which `key` names in messages. Errors: SceneError."""
    found = read_lying(path, key)
    return cover_of(found, key) if str(found["kind"]) == "cover" else resting_of(found, key)


def surface_of(snow: Cover | Resting) -> Triangles:
    """Return the closed surface of snow that lies, for more to fall on."""
    return skin(snow) if isinstance(snow, Cover) else snow.surface


MOST_CELLS = 20_000_000
"""Of a raster."""


def require_few(raster: Raster, key: str, cell: float) -> None:
    """Refuse a raster that is too fine for its size. Errors: SceneError."""
    if raster.nx * raster.ny > MOST_CELLS:
        raise SceneError(
            f"{key} = {cell:g} makes {raster.nx} x {raster.ny} cells, more than {MOST_CELLS:,}: make it "
            "larger, or let it snow on less"
        )


def around(fall: Snowfall, placed: Placed, pieces: Sequence[Piece]) -> Surroundings:
    """Return the solids where they are at the start, and further `pieces`, around the rectangle of `fall`.

    A body that moves at the start was not there when it snowed.
    """
    middle, extent = np.array(fall.center), max(fall.size)
    there = [pair for pair in placed if pair[0].motion != "dynamic" or not is_moving(pair[1])]
    return joined([*(piece_of_solid(solid, pose, middle, extent) for solid, pose in there), *pieces])


def is_moving(pose: Pose) -> bool:
    """Return whether a solid moves or turns."""
    return bool(np.any(pose.velocity) or np.any(pose.omega))


def piece_of_source(source: Source, name: str) -> Piece:
    """Return the surface of the snow of a source. Errors: SceneError if it has none that is known."""
    if isinstance(source, Text) or (isinstance(source, Layer) and (source.on == "terrain" or source.mask)):
        raise SceneError(
            f'{name} has shape = "{source.shape}", on which no snow can fall: put it after the snowfall'
        )
    if isinstance(source, Layer) and source.outline:
        raise SceneError(f"{name} has an outline, on which no snow can fall: put it after the snowfall")
    rotation = rotation_matrix(np.radians(source.turned))
    if isinstance(source, Mesh):
        surface = read_mesh(source, name)
        vertices: NDArray[np.float64] = surface.vertices
        faces, is_sheet = surface.faces, source.thickness > 0
    else:
        unit, faces = type(source).unit_surface()
        vertices, is_sheet = unit * np.array(source.half_extents()), False
    moved = Triangles(product(vertices, rotation.T) + np.array(source.place), faces)
    return piece_of_triangles(name, moved, is_sheet)
