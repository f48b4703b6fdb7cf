"""Describe bodies, which forces move: loose, hinged or sliding ones, and robots from files."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from neve.scene.schema.roles import OneOfItsShapes, Role, Surface
from neve.scene.values.fields import (
    ZERO,
    Angle3,
    Color,
    Coordinate,
    Part,
    Point3,
    Rate3,
    Real,
    Switch,
    Whole,
    check_file,
    check_times,
    entry,
    file_entry,
    norm,
    wrong,
)

ROBOTS = (".xml", ".urdf")
"""What a robot file may end in."""

ROTATION = "Rotation vector (axis times angle) from the shape's own axes to the world's, at the start."
DENSITY = 1000.0
"""Density of a body that says nothing about its mass [kg/m3]."""


class Target(Part):
    """Set the target of a motor at one moment."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    value: Coordinate = entry(0.0, "The target then, in the unit of `target`.", "1")


class Motor(Part):
    """Drive the joint of a body."""

    kind: Literal["velocity", "position", "torque"] = entry(
        "velocity",
        'What the motor controls: "velocity": a speed, with a force of `gain` times the error; "position": a '
        'position, like a critically damped spring; "torque": a force or torque, which is the target itself.',
        "",
    )
    target: Coordinate = entry(
        0.0,
        "Target value. Of a hinge: rad/s, degrees from the start, or N m; of a slide: m/s, m or N.",
        "1",
    )
    keyframes: tuple[Target, ...] = entry(
        (),
        "Targets at increasing times, straight lines between, constant before the first and after the last. "
        "Takes the place of `target`.",
        "",
    )
    gain: Real | None = entry(
        None,
        "Force or torque for each unit of error (of a position: N/m or N m/rad); left out, chosen so that "
        "the body alone reaches its target in about 0.05 s; under load it needs more.",
        "SI",
        gt=0,
        le=1e12,
    )
    limit: Real | None = entry(
        None, "Largest force [N] or torque [N m] either way; left out, none.", "SI", gt=0, le=1e12
    )

    @model_validator(mode="after")
    def _check(self) -> Motor:
        check_times(self.keyframes)
        if self.keyframes and self.target != 0.0:
            raise wrong("target", "cannot be combined with keyframes; leave one of them out")
        if self.kind == "torque" and self.gain is not None:
            raise wrong("gain", 'is of no use to kind = "torque", whose target is the torque; leave it out')
        return self


class Body(Surface, Role):
    """A body: snow and other forces move it."""

    role = "body"

    density: Real | None = entry(
        None,
        f"Density of the whole body; left out, and `mass` too, {DENSITY:g}. Excludes `mass`.",
        "kg/m3",
        "of water; our choice",
        gt=0,
        le=1e6,
    )
    mass: Real | None = entry(
        None, "Mass, spread evenly through the body. Excludes `density`.", "kg", gt=0, le=1e12
    )
    friction: Real = entry(
        0.5,
        "Coulomb friction with colliders and other bodies; of two bodies that touch the larger one counts.",
        "1",
        ge=0,
        le=100,
    )
    contacts: Switch = entry(
        True, "Whether the body touches colliders and other bodies; it always touches snow.", ""
    )
    velocity: Rate3 = entry(ZERO, "Velocity of the body's centre at the start.", "m/s")
    spin: Rate3 = entry(ZERO, "Angular velocity at the start.", "rad/s")
    joint: Literal["free", "hinge", "slide"] = entry(
        "free",
        '"free": any motion; "hinge": turns about a line that is fixed in `parent`; "slide": moves along it.',
        "",
    )
    axis: Point3 = entry(
        (0.0, 0.0, 1.0),
        "Direction of the joint at the start in the world, of any length but zero; not used when free.",
        "1",
    )
    anchor: Point3 | None = entry(
        None, "A point of the hinge's line at the start; left out, the body's centre.", "m"
    )
    limits: tuple[Coordinate, Coordinate] | None = entry(
        None,
        "Least and largest angle (of a slide: displacement) from the start; left out, none.",
        "degrees or m",
    )
    parent: Whole | None = entry(
        None,
        "Number of an earlier body that holds the joint, the first of `[[bodies]]` being 0; left out, the "
        "world.",
        "1",
        ge=0,
    )
    motor: Motor | None = entry(None, "What drives the joint; left out, nothing.", "")
    rotation: Angle3 = entry(ZERO, ROTATION, "degrees")

    @model_validator(mode="after")
    def _check_keys(self) -> Body:
        if self.density is not None and self.mass is not None:
            raise wrong("density", "cannot be combined with mass; leave one of them out")
        if self.joint == "free":
            self._check_free()
        else:
            self._check_joint()
        return self

    def _check_free(self) -> None:
        for key in ("anchor", "limits", "parent", "motor"):
            if getattr(self, key) is not None:
                raise wrong(key, 'needs joint = "hinge" or "slide"; a free body has none')

    def _check_joint(self) -> None:
        if norm(self.axis) < 1e-9:
            raise wrong("axis", "must not be the zero vector; [0, 0, 1] is upward")
        if self.limits is not None and not self.limits[0] <= 0.0 <= self.limits[1] > self.limits[0]:
            raise wrong("limits", "must hold the start, 0, and the first must be less than the second")
        other, own = ("velocity", "spin") if self.joint == "hinge" else ("spin", "velocity")
        if norm(getattr(self, other)) > 0:
            raise wrong(other, f'cannot be kept by joint = "{self.joint}"; set {own} along axis')
        rate = getattr(self, own)
        x, y, z = rate
        a, b, c = self.axis
        across = norm((y * c - z * b, z * a - x * c, x * b - y * a))
        if across > 1e-6 * norm(rate) * norm(self.axis):
            raise wrong(own, f'must be along axis, the only way that joint = "{self.joint}" leaves')
        if self.joint == "slide" and self.anchor is not None:
            raise wrong("anchor", 'is of no use to joint = "slide"; leave it out')


AnyBody = Annotated[Body, OneOfItsShapes()]
"""A body of any shape."""


class Control(Part):
    """Set the control of a robot's actuator at one moment."""

    t: Real = entry(0.0, "Time.", "s", ge=0, le=1e6)
    actuator: str = entry("", "Name of the actuator; in a URDF file, which has none, that of a joint.", "")
    value: Coordinate = entry(
        0.0,
        "Its control, in the unit of the actuator; for a joint of a URDF file: where to go [rad or m], or, "
        "if it has no limits, how fast [rad/s or m/s].",
        "1",
    )


class Robot(Surface):
    """Place a robot or a vehicle that is described in a file."""

    file: str = file_entry("An MJCF (.xml) or URDF file, relative to the scene file.", ROBOTS)
    position: Point3 = entry(ZERO, "Where the origin of the file goes.", "m")
    rotation: Angle3 = entry(
        ZERO, "Rotation vector (axis times angle) from the file's axes to the world's.", "degrees"
    )
    free: Switch = entry(
        False, "Whether to let a base move freely that the file holds fixed, as most URDF files do.", ""
    )
    start: str = entry(
        "", "Name of the file's keyframe that holds the joints and controls at the start; left out, none.", ""
    )
    color: Color | None = entry(
        None, "Red, green and blue in the film; left out, each part's colour in the file.", "1"
    )
    controls: tuple[Control, ...] = entry(
        (),
        "Controls of the actuators; for each actuator at increasing times, straight lines between, constant "
        "before the first and after the last. An actuator without controls gets 0.",
        "",
    )

    @model_validator(mode="after")
    def _check_robot(self) -> Robot:
        check_file(self.file, ROBOTS, "a robot")
        return self
