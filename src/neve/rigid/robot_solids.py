"""Turn the geoms of a robot that collide into solids: what the engine calls a geom, snow meets as a solid."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.colliders.solid import Solid
from neve.geometry.mesh import DOUBTFUL_SHARE, doubtful_share
from neve.geometry.sdf import SolidMesh, filled
from neve.geometry.triangles import tidied
from neve.rigid.engine import engine
from neve.rigid.robots import LoadedRobot
from neve.scene.schema.roles import SHAPES

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
Faces = NDArray[np.int32]

ROUND = 48
"""Corners of the polygon that stands for a circle: it lies at most 0.2 % of the radius inside."""


@dataclass(frozen=True, eq=False)
class Attachment:
    """Hold on which body of the engine a solid's frame is fixed, and where in that body's frame."""

    body: int
    position: Array
    rotation: Array


def robot_solids(model: Any, loaded: LoadedRobot, dx: float) -> Iterator[tuple[Solid, Attachment]]:
    """Yield each geom of a robot that collides, as a solid for a snow grid of spacing `dx` [m].

    The frame of such a solid is that of the engine's geom: the centre of a simple shape; of a mesh its centre
    of mass with the principal axes.
    """
    for geom in loaded.geoms:
        name = f"{loaded.name}.{geom}"
        index = int(model.geom(name).id)
        axes = np.zeros(9)
        engine().mju_quat2Mat(axes, model.geom_quat[index])
        body = int(model.geom_bodyid[index])
        yield (
            _solid(model, index, loaded, name, dx),
            Attachment(body, np.array(model.geom_pos[index]), axes.reshape(3, 3)),
        )


def _solid(model: Any, index: int, loaded: LoadedRobot, name: str, dx: float) -> Solid:
    shape, half = _simple(model, index)
    robot = loaded.robot
    material = int(model.geom_matid[index])
    rgba = model.geom_rgba[index] if material < 0 else model.mat_rgba[material]
    r, g, b = (float(c) for c in rgba[:3])
    return Solid(
        name=name,
        shape=shape,
        half=half,
        mode=robot.mode,
        mu_c=robot.mu_c,
        color=robot.color or (r, g, b),
        finish=robot.finish,
        visible=robot.visible,
        motion="dynamic",
        mesh=_mesh(model, index, dx) if shape == "mesh" else None,
        terrain=_terrain(model, index) if shape == "terrain" else None,
    )


def _simple(model: Any, index: int) -> tuple[str, Array]:
    """Return the shape of a geom and its `Solid.half`."""
    kinds = engine().mjtGeom
    kind = int(model.geom_type[index])
    if kind == kinds.mjGEOM_HFIELD:
        return "terrain", np.zeros(3)
    for word, form in SHAPES.items():
        if form.geom and kind == getattr(kinds, f"mjGEOM_{form.geom}"):
            return word, np.array(form.half_of_geom(model.geom_size[index]))
    return "mesh", np.zeros(3)


def _mesh(model: Any, index: int, dx: float) -> SolidMesh:
    """Return the triangles and distances of a capsule, an ellipsoid or a mesh.

    A mesh that is open, so that it has no inside, counts as its convex hull, as it does for the engine.
    """
    kinds = engine().mjtGeom
    size = model.geom_size[index]
    if model.geom_type[index] == kinds.mjGEOM_CAPSULE:
        return filled(tidied(*rounded(np.full(3, size[0]), float(size[1]))), dx)
    if model.geom_type[index] == kinds.mjGEOM_ELLIPSOID:
        return filled(tidied(*rounded(np.array(size), 0.0)), dx)
    mesh = int(model.geom_dataid[index])
    v, n = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    f, m = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    vertices = np.array(model.mesh_vert[v : v + n], dtype=np.float64)
    surface = tidied(vertices, np.array(model.mesh_face[f : f + m], dtype=np.int32))
    if surface.open_edges and doubtful_share(surface) > DOUBTFUL_SHARE:
        from scipy.spatial import ConvexHull

        surface = tidied(vertices, np.asarray(ConvexHull(vertices).simplices))
    return filled(surface, dx)


def _terrain(model: Any, index: int) -> HeightField:
    """Return the height field of a geom: rows of the engine's go along y, columns along x."""
    field = int(model.geom_dataid[index])
    begin, rows, columns = (int(a[field]) for a in (model.hfield_adr, model.hfield_nrow, model.hfield_ncol))
    x, y, z, _ = (float(s) for s in model.hfield_size[field])
    heights = z * np.array(model.hfield_data[begin : begin + rows * columns]).reshape(rows, columns).T
    return _core.geometry.HeightField(
        np.ascontiguousarray(heights, dtype=np.float32), np.array([2 * x, 2 * y])
    )


def rounded(radii: Array, half: float) -> tuple[Array, Faces]:
    """Return an ellipsoid of `radii` (3,), cut at its equator and drawn apart by `half` each way along z.

    Vertices (n, 3) and faces (m, 3) that look outward: a capsule if the radii are equal. The corners lie on
    the surface.
    """
    latitudes = 0.5 * np.pi * np.linspace(-1.0, 1.0, ROUND // 2 + 1)
    shifts = np.where(latitudes < 0, -half, half)
    if half > 0:
        latitudes = np.insert(latitudes, ROUND // 4, 0.0)
        shifts = np.insert(shifts, ROUND // 4, -half)
    around = 2.0 * np.pi * np.arange(ROUND) / ROUND
    ring = np.array([(math.cos(turn), math.sin(turn)) for turn in around])
    rings = [
        np.column_stack([math.cos(a) * ring * radii[:2], np.full(ROUND, radii[2] * math.sin(a) + s)])
        for a, s in zip(latitudes[1:-1], shifts[1:-1], strict=True)
    ]
    poles = np.array([[0.0, 0.0, -radii[2] - half], [0.0, 0.0, radii[2] + half]])
    vertices = np.concatenate([*rings, poles])
    here, there = np.arange(ROUND), np.roll(np.arange(ROUND), -1)
    faces = [np.column_stack([np.full(ROUND, len(vertices) - 2), there, here])]
    for k in range(len(rings) - 1):
        a, b = k * ROUND + here, k * ROUND + there
        faces += [np.column_stack([a, b, b + ROUND]), np.column_stack([a, b + ROUND, a + ROUND])]
    last = (len(rings) - 1) * ROUND
    faces.append(np.column_stack([last + here, last + there, np.full(ROUND, len(vertices) - 1)]))
    return vertices, np.concatenate(faces).astype(np.int32)
