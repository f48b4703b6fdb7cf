"""Describe the bodies that snow meets: simple shapes, meshes and terrain, at rest or moved by a script."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from neve.scene.schema.fields import (
    CONTACT,
    MODES,
    ZERO,
    Angle3,
    Color,
    Finish,
    Length,
    Part,
    Point3,
    Rate3,
    Real,
    Size2,
    Size3,
    Switch,
    check_times,
    entry,
    file_entry,
    norm,
    wrong,
)
from neve.scene.schema.meshes import MeshFile, check_file

MAPS = (".png", ".tif", ".tiff", ".npy")
"""What a height map may end in."""

ROTATION = "Rotation vector (axis times angle) from the body's own axes to the world's."


class Keyframe(Part):
    """Say where a body is at one moment."""

    t: Real = entry(0.0, "The moment.", "s", ge=0)
    position: Point3 | None = entry(
        None, "Centre (of a plane: its point) at `t`; left out, the body's own.", "m"
    )
    rotation: Angle3 | None = entry(
        None,
        "Rotation vector at `t`; left out, the body's own. Between two keyframes a body takes the shorter "
        "way round, less than half a turn. A plane's normal is turned by it.",
        "degrees",
    )


class Body(Part):
    """Hold what all colliders share."""

    mode: Literal["separate", "slip", "sticky"] = entry("separate", MODES, "", CONTACT)
    mu_c: Real = entry(
        0.5, "Coulomb friction between snow and this body; not used when sticky.", "1", ge=0, le=100
    )
    velocity: Rate3 = entry(ZERO, "Constant velocity of the body.", "m/s")
    spin: Rate3 = entry(
        ZERO, "Constant angular velocity about the body's centre (of a plane: its point).", "rad/s"
    )
    keyframes: tuple[Keyframe, ...] = entry(
        (),
        "Positions and rotations at increasing times; the body rests before the first and after the last. "
        "In between it moves and turns at a constant rate. Excludes velocity and spin.",
        "",
    )
    color: Color | None = entry(None, "Red, green and blue in the film; left out, a colour is chosen.", "1")
    finish: Finish | None = entry(
        None,
        "What the surface in the film is made of; left out, paint, and frozen ground of a plane or terrain "
        "without a colour.",
        "",
    )
    visible: Switch = entry(True, "Whether the film shows the body.", "")

    @model_validator(mode="after")
    def _check(self) -> Body:
        if self.keyframes and self.velocity != ZERO:
            raise wrong("velocity", "cannot be combined with keyframes; leave one of them out")
        if self.keyframes and self.spin != ZERO:
            raise wrong("spin", "cannot be combined with keyframes; leave one of them out")
        check_times(self.keyframes)
        return self


class Plane(Body):
    """Fill the half-space below a plane."""

    shape: Literal["plane"] = entry("plane", "An endless plane.")
    point: Point3 = entry(ZERO, "A point of the plane.", "m")
    normal: Point3 = entry((0.0, 0.0, 1.0), "Direction out of the body, of any length but zero.", "1")

    @model_validator(mode="after")
    def _normal(self) -> Plane:
        if norm(self.normal) < 1e-9:
            raise wrong("normal", "must not be the zero vector; [0, 0, 1] is upward")
        return self


class Box(Body):
    """Place a box or a plate."""

    shape: Literal["box"] = entry("box", "A box or a plate.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the box.", "m")
    size: Size3 = entry((1.0, 1.0, 1.0), "Edge lengths along the box's own x, y and z.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")


class Sphere(Body):
    """Place a ball."""

    shape: Literal["sphere"] = entry("sphere", "A ball.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the ball.", "m")
    radius: Length = entry(0.5, "Radius of the ball.", "m")


class Cylinder(Body):
    """Place a cylinder."""

    shape: Literal["cylinder"] = entry("cylinder", "A cylinder around its own z axis.")
    center: Point3 = entry((0.0, 0.0, 0.5), "Centre of the cylinder, halfway up.", "m")
    radius: Length = entry(0.5, "Radius of the cylinder.", "m")
    height: Length = entry(1.0, "Height of the cylinder along its own z.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")


class Mesh(MeshFile, Body):
    """Place a body from a mesh file."""

    shape: Literal["mesh"] = entry("mesh", "A triangle mesh from a file.")
    center: Point3 = entry(ZERO, "Where the origin of the file goes.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")


class Terrain(Body):
    """Fill the ground below a height map; beyond its edges the height of the edge goes on."""

    shape: Literal["terrain"] = entry("terrain", "Ground from a height map.")
    file: str = file_entry(
        "A PNG or TIFF picture of one channel seen from above (x to the right, y upward), a GeoTIFF, or a "
        'NumPy array heights[x, y] (NPY), relative to the scene file; "neve:NAME" is a map that comes '
        "with Neve.",
        MAPS,
        "terrains",
    )
    size: Size2 | None = entry(
        None, "Extent along x and y; left out, that of the pixels of a GeoTIFF in metres.", "m"
    )
    height: Length = entry(
        1.0,
        "Of a map of 8 or 16 bits: the height of its full range, 255 or 65535 (of heights in whole metres, "
        "65535). Of a map of real or longer numbers: a factor on them.",
        "m",
    )
    center: Point3 = entry(ZERO, "Middle of the map, at the height of the value 0.", "m")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    @model_validator(mode="after")
    def _file(self) -> Terrain:
        check_file(self.file, MAPS, "a height map")
        return self


Collider = Annotated[Plane | Box | Sphere | Cylinder | Mesh | Terrain, Field(discriminator="shape")]
"""Any collider; its `shape` says which."""
