"""Fill the inside of a mesh: where it is, how far below the surface, and how much there is of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.geometry import inside
from neve.geometry.sdf import SolidMesh, solid_mesh
from neve.geometry.triangles import Triangles
from neve.sampling.room import require_room
from neve.scene.errors import SceneError
from neve.scene.schema.file_shapes import Mesh
from neve.scene.schema.scene import Numerics

Array = NDArray[np.float64]

MOST_COUNTED = 2_000_000
"""Points at which the inside of an open mesh is measured."""
FAR_OFF = 0.3
"""Share of the measured volume by which that of an open mesh may differ: thin parts measure too small."""


@dataclass(frozen=True, eq=False)
class MeshSpace:
    """Hold the inside of a mesh in the axes of its source.

    Attributes:
        mesh: triangles and distances
        low, high: corners of the smallest box around it [m], (3,)
        margin: half the thickness of the solid around an open mesh [m]
        volume: of the inside [m3]
    """

    mesh: SolidMesh
    low: Array
    high: Array
    margin: float
    volume: float

    @property
    def corners(self) -> Array:
        """Corners of the triangles [m], (n, 3)."""
        return self.mesh.vertices

    def distance(self, x: Array) -> Array:
        """Return the signed distance [m] (n,) of points `x` [m] (n, 3), negative inside."""
        phi, _ = self.mesh.sdf.sample(np.ascontiguousarray(x))
        return np.asarray(phi, dtype=np.float64)


def mesh_space(source: Mesh, numerics: Numerics, name: str) -> MeshSpace:
    """Return the space inside the mesh of `source`.

    `name`: used in messages.

    Errors: SceneError for a mesh that cannot be used; see `neve.geometry.mesh.read_mesh`.
    """
    margin = 0.5 * source.thickness

    def check(surface: Triangles) -> None:
        size = surface.high - surface.low + 2.0 * margin
        sheet = surface.area * source.thickness
        require_room(size, sheet or abs(surface.volume), numerics, name)

    mesh = solid_mesh(source, numerics.dx, name, check)
    low, high = mesh.surface.low - margin, mesh.surface.high + margin
    volume = _volume(mesh, low, high)
    if volume <= 0:
        raise SceneError(
            f"{name} has no room for snow: set a smaller {name}.detail, or a larger {name}.scale"
        )
    return MeshSpace(mesh, low, high, margin, volume)


def _volume(mesh: SolidMesh, low: Array, high: Array) -> float:
    """Return the volume inside [m3]: exact if the surface is closed, or its holes flat, and no parts overlap.

    See `neve.geometry.inside.volume`; where that is far off, or with a thickness, the grid is measured.
    """
    surface = mesh.surface
    if mesh.thickness > 0:
        return measured_volume(mesh, low, high)
    found = inside.volume(surface)
    if surface.open_edges == 0 and found > 0:
        return found
    measured = measured_volume(mesh, low, high)
    return found if abs(found - measured) < FAR_OFF * measured else measured


def measured_volume(mesh: SolidMesh, low: Array, high: Array) -> float:
    """Return the volume [m3] where the distance in the box from `low` to `high` [m] (3,) is negative.

    Sums over cells of edge h the share min(max(1/2 - phi / h, 0), 1) of each that is inside: exact for a flat
    surface along the cells, with an error of the order h^2 for a smooth one.
    """
    size = high - low
    h = max(mesh.spacing, float(np.prod(size) / MOST_COUNTED) ** (1 / 3))
    count = np.maximum(1, np.ceil(size / h)).astype(np.int64)
    step = size / count
    width = float(np.prod(step)) ** (1 / 3)
    x, y, z = (low[k] + (np.arange(count[k]) + 0.5) * step[k] for k in range(3))
    layer = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
    total = 0.0
    for at in x:
        phi, _ = mesh.sdf.sample(np.column_stack([np.full(len(layer), at), layer]))
        total += float(np.clip(0.5 - np.asarray(phi, dtype=np.float64) / width, 0.0, 1.0).sum())
    return total * float(np.prod(step))
