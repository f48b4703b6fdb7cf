"""Shapes: each is written once, here, and is a source, a collider or a body by its role (`roles.py`)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from neve.reproducible import norms, product
from neve.scene.values import surfaces
from neve.scene.values.fields import (
    ZERO,
    Angle3,
    Length,
    Part,
    Point3,
    Size3,
    entry,
    norm,
    wrong,
)

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

ROTATION = "Rotation vector (axis times angle) from the shape's own axes to the world's."
ROLES = ("source", "collider", "body", "emitter", "sink")


class Shape(Part):
    """Hold the size of a shape and where it is; say what follows from that.

    A shape of a formula is given to the core as three half extents along its own axes, `half` [m] (3,); the
    static methods are functions of these. A shape that is read from a file has neither.

    Attributes:
        roles: what it can be
        endless: whether it has no bounds, as the ground
        has_flat_faces: whether its surface is planes, along which a belt can run
        place_key: its key for the origin of its frame
        geom: what the rigid-body engine, MuJoCo, calls it; "" if it has no such shape
    """

    roles: ClassVar[tuple[str, ...]] = ROLES
    endless: ClassVar[bool] = False
    has_flat_faces: ClassVar[bool] = False
    place_key: ClassVar[str] = "center"
    geom: ClassVar[str] = ""

    unit_surface: ClassVar[Callable[[], surfaces.Surface]] = staticmethod(surfaces.cube)
    """Its triangles with half extents of 1; of an endless one a part of it."""

    if TYPE_CHECKING:  # the key of each shape, which holds no word but its own
        shape: str

    @property
    def place(self) -> Vector:
        """Where the origin of its frame is in the world [m]."""
        return tuple(getattr(self, self.place_key))

    @property
    def turned(self) -> Vector:
        """Rotation vector from its own axes to the world's [degrees]."""
        return getattr(self, "rotation", ZERO)

    @property
    def facing(self) -> Vector | None:
        """Direction in the world of its own z before it is `turned`; None if that is the world's z."""
        return None

    def half_extents(self) -> Vector:
        """Return the three numbers that stand for its size in the core [m]; zeros if it has none."""
        return ZERO

    def thinnest(self) -> tuple[str, float] | None:
        """Return the key and the length of the thinnest way through it [m]; None if no key tells."""
        return None

    def reach(self) -> float:
        """Return how far its farthest point may lie from its origin [m]; 0 if no key tells."""
        return self.reach_of(np.array(self.half_extents()))

    @staticmethod
    def reach_of(half: Array) -> float:
        """Return the distance of its farthest point from its origin [m]."""
        return math.hypot(*half)

    def volume(self) -> float:
        """Return its volume [m3]."""
        return self.volume_of(np.array(self.half_extents()))

    def within(self, x: Array) -> NDArray[np.bool_]:
        """Return which points `x` [m] (n, 3) of the box around it, from its middle, are inside, (n,)."""
        return self.covers(np.array(self.half_extents()), x)

    @staticmethod
    def volume_of(half: Array) -> float:
        """Return its volume [m3]."""
        a, b, c = (float(h) for h in half)
        return 8 * a * b * c

    @staticmethod
    def mean_squares(half: Array) -> Array:
        """Return the mean of x^2, y^2 and z^2 over its inside [m2], (3,)."""
        a, b, c = (float(h) for h in half)
        return np.array([a * a, b * b, c * c]) / 3

    @staticmethod
    def covers(half: Array, x: Array) -> NDArray[np.bool_]:
        """Return which points `x` [m] (n, 3) of the box of these half extents are inside, (n,)."""
        return np.ones(len(x), dtype=bool)

    @staticmethod
    def depth_of(half: Array, x: Array) -> Array:
        """Return how far below its surface the inner points `x` [m] (n, 3) are [m], (n,)."""
        return np.asarray((half - np.abs(x)).min(axis=1))

    @staticmethod
    def lowest_of(half: Array, z: float, up: Array) -> float:
        """Return the height of its lowest point [m]; `z`: of its origin [m], `up`: world's z in its axes."""
        return float(z - product(np.abs(up), half))

    @staticmethod
    def geom_size(half: Array) -> list[float]:
        """Return the size of the engine's geom [m]."""
        return [float(h) for h in half]

    @staticmethod
    def half_of_geom(size: Any) -> list[float]:
        """Return the half extents of an engine's geom of this `size` [m]."""
        return [float(s) for s in size]


class Plane(Shape):
    """Fill the half-space below a plane; in its own frame the plane is z = 0."""

    roles = ("collider",)
    endless = True
    has_flat_faces = True
    place_key = "point"
    geom = "PLANE"
    unit_surface = staticmethod(surfaces.square)

    shape: Literal["plane"] = entry("plane", "The half-space below an endless plane.")
    point: Point3 = entry(ZERO, "A point of the plane.", "m")
    normal: Point3 = entry((0.0, 0.0, 1.0), "Direction out of the solid, of any length but zero.", "1")

    @property
    def facing(self) -> Vector | None:
        """Direction of the normal."""
        return self.normal

    @staticmethod
    def geom_size(half: Array) -> list[float]:
        """Return no extent, and the spacing of the grid that the engine would draw [m]."""
        return [0.0, 0.0, 1.0]

    @staticmethod
    def half_of_geom(size: Any) -> list[float]:
        """Return zeros: it has no extent."""
        return list(ZERO)

    @model_validator(mode="after")
    def _check_normal(self) -> Plane:
        if norm(self.normal) < 1e-9:
            raise wrong("normal", "must not be the zero vector; [0, 0, 1] is upward")
        return self


class Box(Shape):
    """Fill a box or a plate."""

    has_flat_faces = True
    geom = "BOX"

    shape: Literal["box"] = entry("box", "A box or a plate, such as the blade of a plow.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the box.", "m")
    size: Size3 = entry((1.0, 1.0, 1.0), "Edge lengths along the box's own x, y and z.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    def half_extents(self) -> Vector:
        """Return half of each edge [m]."""
        x, y, z = self.size
        return 0.5 * x, 0.5 * y, 0.5 * z

    def thinnest(self) -> tuple[str, float] | None:
        """Return the shortest edge [m]."""
        return "size", min(self.size)


class Sphere(Shape):
    """Fill a ball."""

    geom = "SPHERE"
    unit_surface = staticmethod(surfaces.ball)

    shape: Literal["sphere"] = entry("sphere", "A ball.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the ball.", "m")
    radius: Length = entry(0.5, "Radius of the ball.", "m")

    def half_extents(self) -> Vector:
        """Return the radius, three times [m]."""
        return self.radius, self.radius, self.radius

    def thinnest(self) -> tuple[str, float] | None:
        """Return the diameter [m]."""
        return "radius", 2 * self.radius

    @staticmethod
    def reach_of(half: Array) -> float:
        """Return the radius [m]."""
        return float(half[0])

    @staticmethod
    def volume_of(half: Array) -> float:
        """Return 4/3 pi r^3 [m3]."""
        return 4 / 3 * math.pi * float(half[0]) ** 3

    @staticmethod
    def mean_squares(half: Array) -> Array:
        """Return r^2 / 5 along each axis [m2]."""
        r = float(half[0])
        return np.full(3, r * r / 5)

    @staticmethod
    def covers(half: Array, x: Array) -> NDArray[np.bool_]:
        """Return which points are within a radius of the centre."""
        return np.asarray(np.sum(x * x, axis=1) <= float(half[0]) ** 2)

    @staticmethod
    def depth_of(half: Array, x: Array) -> Array:
        """Return the radius less the distance from the centre [m]."""
        return np.asarray(float(half[0]) - norms(x))

    @staticmethod
    def lowest_of(half: Array, z: float, up: Array) -> float:
        """Return the height of its lowest point [m]."""
        return z - float(half[0])

    @staticmethod
    def geom_size(half: Array) -> list[float]:
        """Return the radius [m]."""
        return [float(half[0]), 0.0, 0.0]

    @staticmethod
    def half_of_geom(size: Any) -> list[float]:
        """Return the radius, three times [m]."""
        return [float(size[0])] * 3


class Cylinder(Shape):
    """Fill a cylinder around its own z axis; half extents: radius, radius, half of the height."""

    geom = "CYLINDER"
    unit_surface = staticmethod(surfaces.tube)

    shape: Literal["cylinder"] = entry("cylinder", "A cylinder around its own z axis.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the cylinder, halfway up.", "m")
    radius: Length = entry(0.5, "Radius of the cylinder.", "m")
    height: Length = entry(1.0, "Height of the cylinder along its own z.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    def half_extents(self) -> Vector:
        """Return radius, radius and half of the height [m]."""
        return self.radius, self.radius, 0.5 * self.height

    def thinnest(self) -> tuple[str, float] | None:
        """Return the diameter or the height [m]."""
        return min(("radius", 2 * self.radius), ("height", self.height), key=lambda pair: pair[1])

    @staticmethod
    def reach_of(half: Array) -> float:
        """Return the distance of its rims from the centre [m]."""
        return float(np.hypot(half[0], half[2]))

    @staticmethod
    def volume_of(half: Array) -> float:
        """Return pi r^2 h [m3]."""
        r, _, c = (float(h) for h in half)
        return 2 * math.pi * r * r * c

    @staticmethod
    def mean_squares(half: Array) -> Array:
        """Return r^2 / 4, r^2 / 4 and h^2 / 12 [m2]."""
        r, _, c = (float(h) for h in half)
        return np.array([r * r / 4, r * r / 4, c * c / 3])

    @staticmethod
    def covers(half: Array, x: Array) -> NDArray[np.bool_]:
        """Return which points are within a radius of the axis."""
        return np.asarray(x[:, 0] ** 2 + x[:, 1] ** 2 <= float(half[0]) ** 2)

    @staticmethod
    def depth_of(half: Array, x: Array) -> Array:
        """Return the distance from the wall or from the nearer end [m]."""
        wall = half[0] - np.hypot(x[:, 0], x[:, 1])
        return np.asarray(np.minimum(wall, half[2] - np.abs(x[:, 2])))

    @staticmethod
    def lowest_of(half: Array, z: float, up: Array) -> float:
        """Return the height of the lower rim's lowest point [m]."""
        along = min(abs(float(up[2])), 1.0)
        return z - float(half[2]) * along - float(half[0]) * math.sqrt(1.0 - along * along)

    @staticmethod
    def geom_size(half: Array) -> list[float]:
        """Return radius and half of the height [m]."""
        return [float(half[0]), float(half[2]), 0.0]

    @staticmethod
    def half_of_geom(size: Any) -> list[float]:
        """Return radius, radius and half of the height [m]."""
        return [float(size[0]), float(size[0]), float(size[1])]


FORMULAS: tuple[type[Shape], ...] = (Plane, Box, Sphere, Cylinder)
"""The shapes that are given by a formula."""
