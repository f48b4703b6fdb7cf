"""Mesh files for the tests, made by hand or with trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

CORNERS = np.array([[x, y, z] for z in (2.75, 3.25) for y in (1.0, 3.0) for x in (0.5, 1.5)])
"""Of a box of 1 x 2 x 0.5 m around (1, 2, 3): 1 m3."""
SIDES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
"""Its quads, anticlockwise from outside."""
TRIANGLES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])


def written(mesh: Any, path: Path) -> str:
    """Write a mesh or a scene of trimesh to `path`; return the path as text."""
    path.write_bytes(mesh.export(file_type=path.suffix[1:]) if path.suffix != ".obj" else _obj(mesh).encode())
    return str(path)


def box(*size: float) -> Any:
    """Return a box of edges `size` around the origin: 12 triangles."""
    return trimesh.creation.box(extents=size)


def ball(radius: float, fineness: int = 3) -> Any:
    """Return a ball of 20 * 4^fineness triangles with corners at `radius`."""
    return trimesh.creation.icosphere(subdivisions=fineness, radius=radius)


def without(mesh: Any, count: int) -> Any:
    """Return `mesh` without its first `count` faces: a hole, for faces that lie together."""
    return trimesh.Trimesh(mesh.vertices, mesh.faces[count:], process=False)


def sheet(edge: float) -> Any:
    """Return a square sheet in the plane z = 0 around the origin."""
    corners = 0.5 * edge * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def joined(*meshes: Any) -> Any:
    """Return the faces of all `meshes` as one mesh, each as it is."""
    begin = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + n for mesh, n in zip(meshes, begin, strict=False)]
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return trimesh.Trimesh(vertices, np.concatenate(faces), process=False)


def _obj(mesh: Any) -> str:
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(mesh.vertices).tolist()]
    return "\n".join([*rows, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in np.asarray(mesh.faces))]) + "\n"
