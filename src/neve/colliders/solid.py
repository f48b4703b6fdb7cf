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
from neve.scene.schema.file_shapes import Mesh, Terrain
from neve.scene.schema.roles import SHAPES
from neve.scene.schema.scene import Body, Collider
from neve.scene.schema.shapes import Shape

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
Color = tuple[float, float, float]
MovedBy = Literal["rest", "script", "engine"]


@dataclass(frozen=True, eq=False)
class Solid:
    """Hold the shape of a collider or a body in its own frame, and how snow slides on it.

    Attributes:
        name: used in messages, tables and pictures: "colliders.0", "bodies.1", "robots.0.wheel_left"
        shape: the word of its shape, see `neve.scene.schema.roles.SHAPES`
        half: half extents along its own axes, as its shape defines them; zero if it has none [m], (3,)
        mode, mu_c: as in the scene
        color: red, green and blue in the film, or None
        finish: what the film shows it to be made of, or None
        visible: whether the film shows it
        moved_by: nobody ("rest"), keyframes or a constant velocity ("script"), or the rigid-body engine
        mesh: triangles and signed distance of a mesh
        terrain: heights of a terrain; its own z points up
    """

    name: str
    shape: str
    half: Array = field(default_factory=lambda: np.zeros(3))
    mode: Literal["separate", "slip", "sticky"] = "separate"
    mu_c: float = 0.5
    color: Color | None = None
    finish: Finish | None = None
    visible: bool = True
    moved_by: MovedBy = "rest"
    mesh: SolidMesh | None = None
    terrain: HeightField | None = None

    @property
    def form(self) -> type[Shape]:
        """The class of its shape, whose static methods are functions of `half`."""
        return SHAPES[self.shape]

    @property
    def endless(self) -> bool:
        """Whether it has no bounds, as the ground."""
        return self.form.endless

    @cached_property
    def reach(self) -> float:
        """Distance of the farthest point of its surface from the origin of its frame [m]."""
        if self.mesh:
            return self.mesh.reach
        return np.inf if self.endless else self.form.reach_of(self.half)


def solid_of(collider: Collider, name: str, dx: float) -> Solid:
    """Return the solid that `collider` describes, as fine as a snow grid of spacing `dx` [m] asks for.

    `name`: used in messages.

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


def solid_of_body(body: Body, name: str, dx: float) -> Solid:
    """Return the solid of `body`, which forces move, for a snow grid of spacing `dx` [m].

    `name`: used in messages.

    Errors: SceneError for a mesh that cannot be used.
    """
    return _solid(body, name, "engine", solid_mesh(body, dx, name) if isinstance(body, Mesh) else None)


def _solid(
    described: Collider | Body,
    name: str,
    moved_by: MovedBy,
    mesh: SolidMesh | None,
    terrain: HeightField | None = None,
) -> Solid:
    """Take over what a solid has from its table in the scene."""
    return Solid(
        name=name,
        shape=described.shape,
        half=np.array(described.half_extents()),
        mode=described.mode,
        mu_c=described.mu_c,
        color=described.color,
        finish=described.finish,
        visible=described.visible,
        moved_by=moved_by,
        mesh=mesh,
        terrain=terrain,
    )
