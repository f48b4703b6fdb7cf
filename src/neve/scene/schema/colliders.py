"""Describe colliders: solids that snow meets, at rest or moved by a script."""

from __future__ import annotations

from typing import Annotated

from pydantic import model_validator

from neve.scene.schema.roles import OneOfItsShapes, Role, Surface
from neve.scene.values.fields import ZERO, Angle3, Part, Point3, Rate3, Real, check_times, entry, wrong


class Keyframe(Part):
    """Say where a collider is at one moment."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    position: Point3 | None = entry(
        None, "Centre (of a plane: its point) at `t`; left out, the collider's own.", "m"
    )
    rotation: Angle3 | None = entry(
        None,
        "Rotation vector at `t`; left out, the collider's own. Between two keyframes it takes the shorter "
        "way round, less than half a turn. A plane's normal is turned by it.",
        "degrees",
    )


class Collider(Surface, Role):
    """A collider: snow meets it; it rests or follows a script."""

    role = "collider"

    velocity: Rate3 = entry(ZERO, "Constant velocity.", "m/s")
    spin: Rate3 = entry(ZERO, "Constant angular velocity about its centre (of a plane: its point).", "rad/s")
    surface_velocity: Rate3 = entry(
        ZERO,
        "Velocity of the surface past a box or a plane, as of a conveyor belt, along the solid's own axes; "
        "what is normal to a face does not count there. Snow rubs on the surface or sticks to it; the solid "
        "stays.",
        "m/s",
    )
    keyframes: tuple[Keyframe, ...] = entry(
        (),
        "Positions and rotations at increasing times; the collider rests before the first and after the "
        "last, and moves and turns at a constant rate in between. Excludes velocity and spin.",
        "",
    )

    @model_validator(mode="after")
    def _check_motion(self) -> Collider:
        if self.keyframes and self.velocity != ZERO:
            raise wrong("velocity", "cannot be combined with keyframes; leave one of them out")
        if self.keyframes and self.spin != ZERO:
            raise wrong("spin", "cannot be combined with keyframes; leave one of them out")
        if self.surface_velocity != ZERO and not self.has_flat_faces:
            raise wrong("surface_velocity", "needs flat faces, as a box or a plane has; turn others by spin")
        check_times(self.keyframes)
        return self


AnyCollider = Annotated[Collider, OneOfItsShapes()]
"""A collider of any shape."""
