"""Solid: what snow can meet, resolved from the scene to a shape and numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from neve.geometry.mesh import warn_if_far
from neve.geometry.sdf import SolidMesh, solid_mesh
from neve.geometry.terrain import height_field
from neve.scene.schema.file_shapes import Mesh, Terrain
from neve.scene.schema.roles import SHAPES
from neve.scene.schema.scene import Body, Collider
from neve.scene.schema.shapes import Shape
from neve.scene.values.fields import Finish

if TYPE_CHECKING:
    from neve._core import HeightField

Array = NDArray[np.float64]
Color = tuple[float, float, float]
Motion = Literal["static", "scripted", "dynamic"]


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
        motion: "static", "scripted" (a collider with keyframes or a constant velocity), or "dynamic" (a body,
            which forces move)
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
    motion: Motion = "static"
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


def solid_of(described: Collider | Body, name: str, dx: float) -> Solid:
    """Return the solid of a collider or a body, as fine as a snow grid of spacing `dx` [m] asks for.

    `name`: used in messages.

    Errors: SceneError for a mesh or a height map that cannot be used.
    """
    mesh = solid_mesh(described, dx, name) if isinstance(described, Mesh) else None
    if mesh is not None and isinstance(described, Mesh):
        warn_if_far(mesh.surface, described, dx, name)
    return Solid(
        name=name,
        shape=described.shape,
        half=np.array(described.half_extents()),
        mode=described.mode,
        mu_c=described.mu_c,
        color=described.color,
        finish=described.finish,
        visible=described.visible,
        motion=_motion(described),
        mesh=mesh,
        terrain=height_field(described, name) if isinstance(described, Terrain) else None,
    )


def _motion(described: Collider | Body) -> Motion:
    if isinstance(described, Body):
        return "dynamic"
    moves = bool(described.keyframes) or any(described.velocity) or any(described.spin)
    return "scripted" if moves else "static"
