"""Give meshes and terrain to the engine: it takes a mesh for its convex hull, and heights row by row."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.solid import Solid
from neve.reproducible import norms
from neve.rigid.engine import engine

Array = NDArray[np.float64]

BEDROCK = 10.0
"""How far the ground of a terrain reaches below its least height for bodies [m]."""


def add_mesh(spec: Any, solid: Solid) -> str:
    """Add the mesh of `solid` to the engine's `spec` and return its name there.

    Of an open mesh with a thickness, the corners on both of its sides.
    """
    assert solid.mesh is not None
    vertices, faces = solid.mesh.vertices, solid.mesh.faces
    if solid.mesh.thickness > 0:
        out = 0.5 * solid.mesh.thickness * corner_normals(vertices, faces)
        vertices = np.concatenate([vertices + out, vertices - out])
        faces = np.concatenate([faces, faces[:, ::-1] + len(out)])
    spec.add_mesh(
        name=solid.name,
        uservert=np.asarray(vertices, dtype=np.float32).reshape(-1),
        userface=np.asarray(faces, dtype=np.int32).reshape(-1),
        inertia=engine().mjtMeshInertia.mjMESH_INERTIA_CONVEX,  # not used, and never refused
    )
    return solid.name


def corner_normals(vertices: Array, faces: NDArray[np.integer]) -> Array:
    """Return a unit normal at each corner (n, 3): the mean of its faces', by their areas."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], np.cross(b - a, c - a))
    length = norms(normals)[:, None]
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def add_terrain(spec: Any, solid: Solid) -> str:
    """Add the heights of `solid` to the engine's `spec` and return their name there.

    The engine counts heights from the least one on, and takes shares of the largest, rows along y.
    """
    field = solid.terrain
    assert field is not None
    shares = np.asarray(field.heights, dtype=np.float64).T - field.low
    top = max(float(shares.max()), 1e-6)
    rows, columns = shares.shape
    x, y = field.size
    made = spec.add_hfield(name=solid.name, nrow=rows, ncol=columns, size=[x / 2, y / 2, top, BEDROCK])
    made.userdata = np.ascontiguousarray(shares / top, dtype=np.float32).reshape(-1)
    return solid.name


def lift_of(solid: Solid) -> Array:
    """Return where the engine's shape has its origin in the frame of `solid` [m], (3,)."""
    low = solid.terrain.low if solid.terrain is not None else 0.0
    return np.array([0.0, 0.0, low])
