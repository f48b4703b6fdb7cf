"""Solid: what snow can meet, resolved from the scene to a shape and numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from neve.geometry.sdf import SolidMesh, solid_mesh
from neve.geometry.terrain import height_field
from neve.scene.schema.fields import Finish
from neve.scene.schema.scene import (
    Box,
    Collider,
    Cylinder,
    Mesh,
    Rigid,
    RigidBox,
    RigidCylinder,
    RigidMesh,
    RigidSphere,
    Sphere,
    Terrain,
)

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
Color = tuple[float, float, float]
Shape = Literal["plane", "box", "sphere", "cylinder", "mesh", "terrain"]
MovedBy = Literal["rest", "script", "engine"]


@dataclass(frozen=True, eq=False)
class Solid:
    """Hold the shape of a body in its own frame, and how snow slides on it.

    A plane is z = 0 with the snow above it, a cylinder's axis is z; box, sphere and cylinder are centred.

    Attributes:
        name: who it is, for messages, tables and pictures: "colliders.0", "bodies.1", "robots.0.wheel_left"
        shape: what it is
        half: half edges of a box; (radius, radius, half height) of a cylinder; the radius, three times, of a
            sphere; else zero [m], (3,)
        mode, mu_c: as in the scene
        color: red, green and blue in the film, or None
        finish: what the film shows it to be made of, or None
        visible: whether the film shows it
        moved_by: nobody ("rest"), keyframes or a constant velocity ("script"), or the rigid-body engine
        mesh: triangles and signed distance of a mesh
        terrain: heights of a terrain; its own z points up
    """

    name: str
    shape: Shape
    half: Array = field(default_factory=lambda: np.zeros(3))
    mode: Literal["separate", "slip", "sticky"] = "separate"
    mu_c: float = 0.5
    color: Color | None = None
    finish: Finish | None = None
    visible: bool = True
    moved_by: MovedBy = "rest"
    mesh: SolidMesh | None = None
    terrain: HeightField | None = None

    @cached_property
    def reach(self) -> float:
        """Distance of the farthest point of its surface from the origin of its frame [m]."""
        if self.shape == "sphere":
            return float(self.half[0])
        if self.shape == "cylinder":
            return float(np.hypot(self.half[0], self.half[2]))
        if self.shape == "box":
            return float(np.linalg.norm(self.half))
        return self.mesh.reach if self.mesh else np.inf


def solid_of(collider: Collider, name: str, dx: float) -> Solid:
    """Return the solid that `collider` describes, as fine as a snow grid of spacing `dx` [m] asks for.

    `name` tells it in messages.

    Errors: SceneError for a mesh or a height map that cannot be used.
    """
    moves = bool(collider.keyframes) or any(collider.velocity) or any(collider.spin)
    return _solid(
        collider,
        name,
        "script" if moves else "rest",
        solid_mesh(collider, dx, name) if isinstance(collider, Mesh) else None,
        height_field(collider, name) if isinstance(collider, Terrain) else None,
    )


def solid_of_body(body: Rigid, name: str, dx: float) -> Solid:
    """Return the solid of `body`, which the engine moves, for a snow grid of spacing `dx` [m].

    `name` tells it in messages.

    Errors: SceneError for a mesh that cannot be used.
    """
    return _solid(body, name, "engine", solid_mesh(body, dx, name) if isinstance(body, RigidMesh) else None)


def _solid(
    part: Collider | Rigid,
    name: str,
    moved_by: MovedBy,
    mesh: SolidMesh | None,
    terrain: HeightField | None = None,
) -> Solid:
    """Take over what a solid has from its part of the scene."""
    return Solid(
        name=name,
        shape=part.shape,
        half=half_extents(part),
        mode=part.mode,
        mu_c=part.mu_c,
        color=part.color,
        finish=part.finish,
        visible=part.visible,
        moved_by=moved_by,
        mesh=mesh,
        terrain=terrain,
    )


def half_extents(shape: Collider | Rigid) -> Array:
    """Return the numbers of a box, sphere or cylinder as `Solid.half` has them; zeros for the others."""
    half = np.zeros(3)
    if isinstance(shape, Box | RigidBox):
        half[:] = 0.5 * np.asarray(shape.size)
    elif isinstance(shape, Sphere | RigidSphere):
        half[:] = shape.radius
    elif isinstance(shape, Cylinder | RigidCylinder):
        half[:] = shape.radius, shape.radius, 0.5 * shape.height
    return half
