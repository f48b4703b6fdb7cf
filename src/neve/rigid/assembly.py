"""Assemble colliders, bodies and robots of a scene into a model of the rigid-body engine, MuJoCo."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.colliders.motion import pose
from neve.colliders.solid import Solid
from neve.geometry.pose import rotation_matrix
from neve.reproducible import product
from neve.rigid.engine import engine, heard, quaternion, reason
from neve.rigid.hulls import add_mesh, add_terrain, lift_of
from neve.rigid.inertia import mass_properties
from neve.rigid.robot_solids import Attachment
from neve.rigid.robots import LoadedRobot, add_robot, place_joints
from neve.scene.errors import SceneError
from neve.scene.schema.bodies import DENSITY, Motor
from neve.scene.schema.scene import Body, Collider, Scene

Array = NDArray[np.float64]

TIME_CONSTANT = 0.002
"""Time in which a contact pushes out what has sunk in [s]: four of the longest steps of the engine."""
RESPONSE = 0.05
"""Time in which a motor without a gain brings the bare body near its target [s]."""

LIGHTEST = 1e-14
"""Least mass and moments of inertia of a body [kg, kg m2]: the engine refuses 1e-15."""


@dataclass(frozen=True, eq=False)
class Control:
    """Hold the control of an actuator: values at increasing times, straight lines between."""

    actuator: int
    times: Array
    values: Array


@dataclass
class Assembly:
    """Hold the engine's model, and where the scene's solids are in it.

    Attributes:
        model: mujoco.MjModel
        attachments: of each solid of bodies, in their order; those of robots follow
        robots: what was read of each robot
        scripted: colliders that move, each with its number among the engine's mocap bodies and its geom
        controls: of the actuators
        start: positions of the joints at the start
        speeds: velocities of the degrees of freedom at the start
    """

    model: Any
    attachments: list[Attachment] = field(default_factory=list)
    scripted: list[tuple[Collider, int, int]] = field(default_factory=list)
    controls: list[Control] = field(default_factory=list)
    robots: list[LoadedRobot] = field(default_factory=list)
    start: Array = field(default_factory=lambda: np.zeros(0))
    speeds: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class _Frame:
    """Hold the engine's frame of a body at the start, centre of mass and principal axes, in the world."""

    position: Array
    rotation: Array

    def inside(self, position: Array, rotation: Array) -> tuple[Array, Array]:
        """Return a position and a rotation in the world as seen from this frame."""
        back = self.rotation.T
        return product(back, position - self.position), product(back, rotation)


def assemble(scene: Scene, colliders: Sequence[Solid], bodies: Sequence[Solid]) -> Assembly:
    """Return the engine's model of everything solid in `scene`.

    `colliders` and `bodies` are the solids of `scene.colliders` and `scene.bodies`, in their order.

    Errors: SceneError for a robot that cannot be read, and for a body that the engine cannot take.
    """
    spec = _new_spec(scene.world.gravity)
    for collider, solid in zip(scene.colliders, colliders, strict=True):
        _add_collider(spec, collider, solid)
    frames: list[_Frame] = []
    for body, solid in zip(scene.bodies, bodies, strict=True):
        frames.append(_add_body(spec, body, solid, frames))
    robots = [add_robot(spec, robot, f"robots.{i}") for i, robot in enumerate(scene.robots)]
    made = Assembly(model=_compiled(spec), robots=robots)
    made.start = place_joints(made.model, robots)
    _find_attachments(made, bodies, scene.bodies, frames)
    _find_scripted(made, scene.colliders, colliders)
    _tune_motors(made, _motors(scene.bodies, bodies, robots))
    made.controls += _controls(made.model, scene.bodies, bodies, robots)
    made.speeds = _speeds(made.model, scene.bodies, bodies, frames)
    return made


def _new_spec(gravity: tuple[float, float, float]) -> Any:
    """Return an empty model with the options that make free bodies exact.

    implicitfast changes the momentum of a free body by force times step to rounding, and a spinning one gains
    no energy (MuJoCo's documentation, numerical integration). No islands: they save time only among many
    heaps of bodies. No automatic reset: a body whose state is not finite must be reported, not put back.
    """
    mujoco = engine()
    spec = mujoco.MjSpec()
    spec.option.gravity = gravity
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # little creep where friction holds
    flags = mujoco.mjtDisableBit
    spec.option.disableflags = int(flags.mjDSBL_ISLAND) | int(flags.mjDSBL_AUTORESET)
    spec.compiler.degree = False
    spec.compiler.conflict = mujoco.mjtConflict.mjCONFLICT_WARNING
    return spec


def _compiled(spec: Any) -> Any:
    try:
        with heard():
            return spec.compile()
    except (ValueError, engine().FatalError) as error:
        element = re.search(r"Element name '([^']+)'", str(error))
        raise SceneError(f"{element[1] if element else 'a body'} cannot be moved: {reason(error)}") from None


def _geom(spec: Any, solid: Solid) -> dict[str, Any]:
    """Return type and size of the engine's geom for `solid`; a mesh or height field is added to `spec`."""
    kinds = engine().mjtGeom
    if solid.mesh:
        return {"type": kinds.mjGEOM_MESH, "meshname": add_mesh(spec, solid)}
    if solid.terrain:
        return {"type": kinds.mjGEOM_HFIELD, "hfieldname": add_terrain(spec, solid)}
    kind = getattr(kinds, f"mjGEOM_{solid.form.geom}")
    return {"type": kind, "size": solid.form.geom_size(solid.half)}


def _add_geom(
    spec: Any, body: Any, solid: Solid, where: tuple[Array, Array], friction: float, meets: bool
) -> None:
    """Add the shape of `solid`, without mass, to a body of the engine, at `where` in its frame."""
    body.add_geom(
        name=solid.name,
        pos=where[0] + product(where[1], lift_of(solid)),
        quat=quaternion(where[1]),
        mass=0.0,
        friction=[friction, 0.005, 0.0001],
        solref=[TIME_CONSTANT, 1.0],
        contype=EVERY if meets else 0,
        conaffinity=EVERY if meets else 0,
        **_geom(spec, solid),
    )


EVERY = 2**31 - 1
"""Contact with every group of geoms that a robot's file may use."""


def _add_collider(spec: Any, collider: Collider, solid: Solid) -> None:
    """Add a collider to the world, or as a mocap body if a script moves it.

    Its own friction is none: of two that touch the larger one counts, and a collider has no say in it.
    """
    at = pose(collider, 0.0)
    if solid.motion != "scripted":
        _add_geom(spec, spec.worldbody, solid, (at.position, at.rotation), 0.0, True)
        return
    body = spec.worldbody.add_body(name=solid.name, mocap=True, pos=at.position, quat=quaternion(at.rotation))
    _add_geom(spec, body, solid, (np.zeros(3), np.eye(3)), 0.0, True)


def _add_body(spec: Any, body: Body, solid: Solid, frames: Sequence[_Frame]) -> _Frame:
    """Add a body with its joint and motor, and return the frame that the engine gives it."""
    properties = mass_properties(solid)
    density = DENSITY if body.density is None else body.density
    mass = density * properties.volume if body.mass is None else body.mass
    moments, axes = properties.principal()
    moments *= mass / properties.volume
    if min(mass, *moments) < LIGHTEST:
        raise SceneError(
            f"{solid.name} has a mass of {mass:.3g} kg and moments of inertia from {min(moments):.3g} kg m2: "
            f"the rigid-body engine needs {LIGHTEST:g} at least, so make it larger or heavier"
        )
    R = rotation_matrix(np.radians(body.rotation))
    center = np.array(body.place)
    frame = _Frame(center + product(R, properties.center), product(R, axes))
    if body.parent is None:
        host, where = spec.worldbody, (frame.position, frame.rotation)
    else:
        host = spec.body(f"bodies.{body.parent}")
        where = frames[body.parent].inside(frame.position, frame.rotation)
    made = host.add_body(
        name=solid.name,
        pos=where[0],
        quat=quaternion(where[1]),
        mass=mass,
        ipos=np.zeros(3),
        inertia=moments,
        explicitinertial=True,
    )
    _add_geom(spec, made, solid, frame.inside(center, R), body.friction, body.contacts)
    _add_joint(spec, made, body, frame, solid.name)
    return frame


def _add_joint(spec: Any, made: Any, body: Body, frame: _Frame, name: str) -> None:
    mujoco = engine()
    if body.joint == "free":
        made.add_freejoint(name=name, align=False)
        return
    hinge = body.joint == "hinge"
    axis = np.array(body.axis) / math.hypot(*body.axis)
    anchor = np.array(body.anchor if body.anchor is not None else body.place)
    kinds = mujoco.mjtJoint
    joint = made.add_joint(
        name=name,
        type=kinds.mjJNT_HINGE if hinge else kinds.mjJNT_SLIDE,
        axis=product(frame.rotation.T, axis),
        pos=product(frame.rotation.T, anchor - frame.position),
    )
    if body.limits is not None:
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = np.radians(body.limits) if hinge else np.array(body.limits)
        joint.solref_limit = [TIME_CONSTANT, 1.0]
    if body.motor:
        motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.set_to_motor()
        if body.motor.limit is not None:
            motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
            motor.forcerange = [-body.motor.limit, body.motor.limit]


def _find_attachments(
    made: Assembly, solids: Sequence[Solid], bodies: Sequence[Body], frames: Sequence[_Frame]
) -> None:
    for solid, body, frame in zip(solids, bodies, frames, strict=True):
        where = frame.inside(np.array(body.place), rotation_matrix(np.radians(body.rotation)))
        made.attachments.append(Attachment(made.model.body(solid.name).id, *where))


def _find_scripted(made: Assembly, colliders: Sequence[Collider], solids: Sequence[Solid]) -> None:
    for collider, solid in zip(colliders, solids, strict=True):
        if solid.motion == "scripted":
            body = made.model.body(solid.name)
            made.scripted.append((collider, int(body.mocapid[0]), int(body.geomadr[0])))


def _motors(
    bodies: Sequence[Body], solids: Sequence[Solid], robots: Sequence[LoadedRobot]
) -> Iterator[tuple[str, Motor]]:
    """Yield the full name of each joint that has a motor here, which is also that of its actuator."""
    for body, solid in zip(bodies, solids, strict=True):
        if body.motor:
            yield solid.name, body.motor
    for loaded in robots:
        for joint, motor in loaded.motors:
            yield f"{loaded.name}.{joint}", motor


def _tune_motors(made: Assembly, motors: Iterable[tuple[str, Motor]]) -> None:
    """Set the gains of motors, from the inertia of the joint at the start where none is given.

    A speed is reached as 1 - exp(-t gain / I), within 5 % at t = 3 I / gain; a position, critically damped,
    as 1 - (1 + w t) exp(-w t), w^2 = gain / I, within 5 % at w t = 4.74.
    """
    mujoco, model = engine(), made.model
    data = mujoco.MjData(model)
    data.qpos[:] = made.start
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    for name, motor in motors:
        dof = model.joint(name).dofadr[0]
        _set_gain(model.actuator(name), motor, float(inertia[dof, dof]))


def _set_gain(actuator: Any, motor: Motor, inertia: float) -> None:
    """Write a motor as force = gain control - bias: MuJoCo's affine actuator."""
    mujoco = engine()
    if motor.kind == "torque":
        return
    actuator.biastype[:] = int(mujoco.mjtBias.mjBIAS_AFFINE)
    if motor.kind == "velocity":
        gain = motor.gain or 3.0 * inertia / RESPONSE
        actuator.gainprm[0], actuator.biasprm[2] = gain, -gain
    else:
        gain = motor.gain or inertia * (4.74 / RESPONSE) ** 2
        actuator.gainprm[0], actuator.biasprm[1] = gain, -gain
        actuator.biasprm[2] = -2.0 * np.sqrt(gain * inertia)


def _controls(
    model: Any, bodies: Sequence[Body], solids: Sequence[Solid], robots: Sequence[LoadedRobot]
) -> Iterator[Control]:
    """Yield the controls of the motors of bodies and of the actuators of robots."""
    for body, solid in zip(bodies, solids, strict=True):
        if body.motor is None:
            continue
        unit = np.pi / 180 if body.joint == "hinge" and body.motor.kind == "position" else 1.0
        keys = [(key.t, key.value) for key in body.motor.keyframes] or [(0.0, body.motor.target)]
        times, values = np.array(keys).T
        yield Control(int(model.actuator(solid.name).id), times, unit * values)
    for loaded in robots:
        for name, times, values in loaded.controls:
            yield Control(int(model.actuator(f"{loaded.name}.{name}").id), times, values)


def _speeds(model: Any, bodies: Sequence[Body], solids: Sequence[Solid], frames: Sequence[_Frame]) -> Array:
    """Return the velocities of all degrees of freedom at the start; of a joint, relative to its parent."""
    speeds = np.zeros(model.nv)
    for body, solid, frame in zip(bodies, solids, frames, strict=True):
        first = int(model.joint(solid.name).dofadr[0])
        velocity, spin = np.array(body.velocity), np.array(body.spin)
        if body.joint == "free":
            arm = frame.position - np.array(body.place)
            speeds[first : first + 3] = velocity + np.cross(spin, arm)
            speeds[first + 3 : first + 6] = product(frame.rotation.T, spin)
        else:
            axis = np.array(body.axis) / math.hypot(*body.axis)
            speeds[first] = np.sum(axis * (spin if body.joint == "hinge" else velocity))
    return speeds
