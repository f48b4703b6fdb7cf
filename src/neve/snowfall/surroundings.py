"""What snow falls on, as triangles in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.colliders.solid import Solid
from neve.colliders.triangles import triangles
from neve.geometry.pose import Pose
from neve.geometry.triangles import Triangles
from neve.reproducible import product

if TYPE_CHECKING:
    from neve._core import TriangleMesh

Array = NDArray[np.float64]
Kind = Literal["closed", "sheet", "ground"]

MOST_HEIGHTS = 2048
"""Samples of a height map along each side at most: a larger one is thinned."""
FAR = 4.0
"""Half of the side of an endless plane, and how far a terrain's edge goes on, in sizes of the rectangle."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Hold the surfaces of all that snow can lie on or is kept off by.

    Attributes:
        vertices: corners [m], (n, 3)
        faces: rows of `vertices`, anticlockwise from outside, (m, 3)
        part: which part each face is of (m,)
        kinds: of each part: "closed", a "sheet" without thickness, or "ground", below which all is filled
        names: of each part
    """

    vertices: Array
    faces: NDArray[np.int32]
    part: NDArray[np.int32]
    kinds: tuple[Kind, ...]
    names: tuple[str, ...]

    @cached_property
    def tree(self) -> TriangleMesh | None:
        """What finds the hits of rays; None if nothing is there."""
        return _core.geometry.TriangleMesh(self.vertices, self.faces) if len(self.faces) else None


Piece = tuple[str, Kind, Array, NDArray[np.int32]]
"""Name, kind, corners in the world (n, 3) [m] and triangles (m, 3) of one part."""


def joined(pieces: Sequence[Piece]) -> Surroundings:
    """Return all `pieces` as one."""
    vertices = [piece[2] for piece in pieces] or [np.zeros((0, 3))]
    offsets = np.cumsum([0, *(len(v) for v in vertices)])
    faces = [piece[3] + offset for piece, offset in zip(pieces, offsets, strict=False)]
    part = [np.full(len(piece[3]), k) for k, piece in enumerate(pieces)]
    empty = np.zeros((0, 3), np.int32)
    return Surroundings(
        np.ascontiguousarray(np.concatenate(vertices)),
        np.ascontiguousarray(np.concatenate(faces or [empty]).astype(np.int32)),
        np.concatenate(part or [np.zeros(0)]).astype(np.int32),
        tuple(piece[1] for piece in pieces),
        tuple(piece[0] for piece in pieces),
    )


def piece_of_solid(solid: Solid, pose: Pose, middle: Array, extent: float) -> Piece:
    """Return a solid where its `pose` has it.

    middle (2,), extent: of the rectangle on which it snows [m], over which the ground reaches.
    """
    far = FAR * extent
    if solid.endless and solid.terrain is None:
        at = product(np.array([*middle, 0.0]) - pose.position, pose.rotation)
        vertices, faces = triangles(solid, far, MOST_HEIGHTS)
        return (
            solid.name,
            "ground",
            product(vertices + np.array([at[0], at[1], 0.0]), pose.rotation.T) + pose.position,
            faces,
        )
    vertices, faces = triangles(solid, far, MOST_HEIGHTS)
    if solid.terrain is not None:
        vertices, faces = _extended(vertices, faces, solid.terrain.heights.shape, far)
    kind: Kind = "ground" if solid.endless else "closed"
    if solid.mesh is not None and (solid.mesh.thickness > 0 or solid.mesh.surface.open_edges):
        kind = "sheet"
    return solid.name, kind, product(vertices, pose.rotation.T) + pose.position, faces


def _extended(
    vertices: Array, faces: NDArray[np.int32], shape: tuple[int, ...], far: float
) -> tuple[Array, NDArray[np.int32]]:
    """Return a terrain with a rim of `far` [m] around it at the heights of its edges."""
    from neve.geometry.heights import triangulated

    rows = min(shape[0], MOST_HEIGHTS)
    grid = vertices.reshape(rows, -1, 3)
    x, y, z = grid[:, 0, 0], grid[0, :, 1], grid[:, :, 2]
    x, y = np.concatenate([[x[0] - far], x, [x[-1] + far]]), np.concatenate([[y[0] - far], y, [y[-1] + far]])
    corners, wider = triangulated(x, y, np.pad(z, 1, mode="edge"))
    return corners, wider


def piece_of_triangles(name: str, surface: Triangles, is_sheet: bool = False) -> Piece:
    """Return a surface that stands in the world; open ones are sheets."""
    kind: Kind = "sheet" if is_sheet or surface.open_edges else "closed"
    return name, kind, surface.vertices, surface.faces
