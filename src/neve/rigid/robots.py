"""Read robots and vehicles from MJCF and URDF files, and put them into the engine's model."""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import rotation_matrix
from neve.reproducible import product
from neve.rigid.engine import engine, heard, quaternion
from neve.rigid.robot_files.helper import require_sound
from neve.rigid.robot_files.kept import dropped_options, keep_compiled
from neve.rigid.robot_files.reading import compiled, free_name, is_urdf, read
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.bodies import Motor, Robot
from neve.spelling import hint, nearest

Array = NDArray[np.float64]


@dataclass
class LoadedRobot:
    """Hold a robot that is part of the engine's model.

    Attributes:
        name: in messages and before the names of its geoms, such as "robots.0"
        robot: what the scene says of it
        geoms: names of its geoms that collide, in the order of the file
        controls: of each actuator that the scene controls: its name, times and values
        motors: joints that get a motor here, because their file has none: name and motor
        start: values of joints at the start, by the joint's name
    """

    name: str
    robot: Robot
    geoms: list[str] = field(default_factory=list)
    controls: list[tuple[str, Array, Array]] = field(default_factory=list)
    motors: list[tuple[str, Motor]] = field(default_factory=list)
    start: dict[str, Array] = field(default_factory=dict)


def add_robot(spec: Any, robot: Robot, name: str) -> LoadedRobot:
    """Read the file of `robot` and add it to `spec`.

    `name`: used in messages.

    Its own options, such as gravity and time step, do not count: those of the scene do. A SceneWarning names
    those of physics.

    Errors: SceneError, one sentence: unreadable, a mesh that is missing, nothing that collides, flexible
    parts, no such actuator, keyframe or range.
    """
    text = f"{name}.file = {json.dumps(robot.file, ensure_ascii=False)}"
    path = Path(robot.file)
    require_sound(path, text)
    child, geoms = read(path, text)
    if robot.free:
        _set_free(child, name)
    loaded = LoadedRobot(name, robot, geoms)
    _name_joints_and_actuators(child)
    if is_urdf(path):
        loaded.motors = _motors(child, robot)
    alone = compiled(child, text)
    _check_controls(loaded, alone)
    _set_start(loaded, alone)
    keep_compiled(child, alone)
    if dropped := dropped_options(child, spec.option):
        warnings.warn(
            f"{text} sets {', '.join(dropped)} in its options, which do not count: what the scene says does",
            SceneWarning,
            stacklevel=2,
        )
    for key in list(child.keys):
        child.delete(key)
    for option in (o for o in dir(spec.option) if not o.startswith("_")):
        setattr(child.option, option, getattr(spec.option, option))
    R = rotation_matrix(np.radians(robot.rotation))
    frame = spec.worldbody.add_frame(pos=robot.position, quat=quaternion(R))
    with heard():
        spec.attach(child, prefix=f"{name}.", frame=frame)
    return loaded


def _set_free(child: Any, name: str) -> None:
    bases = list(child.worldbody.bodies)
    for base in bases:
        if base.joints:
            raise SceneError(
                f'{name}.free = true is not allowed: the base "{base.name}" has a joint in its file'
            )
        base.add_freejoint()


def _name_joints_and_actuators(child: Any) -> None:
    joints, actuators = (
        {element.name for element in elements} for elements in (child.joints, child.actuators)
    )
    for joint in child.joints:
        joint.name = joint.name or free_name(f"{joint.parent.name}_joint", joints)
    for actuator in child.actuators:
        actuator.name = actuator.name or free_name(actuator.target or "actuator", actuators)


def _motors(child: Any, robot: Robot) -> list[tuple[str, Motor]]:
    """Give motors to the joints of a URDF file that are controlled: it has none of its own.

    A joint with limits is brought to a position, an endless one to a speed; the file's effort
    bounds the force.
    """
    mujoco = engine()
    found = []
    known = {joint.name: joint for joint in child.joints}
    for name in dict.fromkeys(control.actuator for control in robot.controls):
        joint = known.get(name)
        if joint is None or joint.type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            continue
        child.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name).set_to_motor()
        endless = joint.range[0] == joint.range[1]
        found.append((name, Motor(kind="velocity" if endless else "position")))
    return found


def _check_controls(loaded: LoadedRobot, alone: Any) -> None:
    """Sort the scene's controls by actuator; refuse an actuator or a value that the robot does not have."""
    names = [alone.actuator(i).name for i in range(alone.nu)]
    timelines: dict[str, list[tuple[float, float]]] = {}
    for i, control in enumerate(loaded.robot.controls):
        where = f"{loaded.name}.controls.{i}"
        if control.actuator not in names:
            near = nearest(control.actuator, names)
            meant = hint(near and f'"{near}"')
            have = f"this robot has {', '.join(names)}" if names else "this robot has none"
            raise SceneError(f'{where}.actuator = "{control.actuator}" is not an actuator{meant}: {have}')
        low, high = _range(alone, names.index(control.actuator), control.actuator, loaded)
        if not low <= control.value <= high:
            raise SceneError(
                f"{where}.value = {control.value:g} is not allowed: "
                f'"{control.actuator}" takes {low:g} to {high:g}'
            )
        line = timelines.setdefault(control.actuator, [])
        if line and control.t <= line[-1][0]:
            raise SceneError(
                f"{where}.t = {control.t:g} is not allowed: it must be later than the one before it for "
                f'"{control.actuator}", greater than {line[-1][0]:g} [s]'
            )
        line.append((control.t, control.value))
    loaded.controls = [(name, *np.array(line).T) for name, line in timelines.items()]


def _range(alone: Any, actuator: int, name: str, loaded: LoadedRobot) -> tuple[float, float]:
    """Return what an actuator takes: its range, or that of the joint that it brings to a position."""
    if alone.actuator_ctrllimited[actuator]:
        low, high = alone.actuator_ctrlrange[actuator]
        return float(low), float(high)
    if (name, Motor(kind="position")) in loaded.motors:
        low, high = alone.joint(name).range
        return float(low), float(high)
    return -np.inf, np.inf


def _set_start(loaded: LoadedRobot, alone: Any) -> None:
    """Take positions of the joints and controls from the keyframe of the file that `start` names."""
    start = loaded.robot.start
    if not start:
        return
    names = [alone.key(i).name for i in range(alone.nkey)]
    if start not in names:
        have = f"its file has {', '.join(names)}" if names else "its file has none"
        raise SceneError(f'{loaded.name}.start = "{start}" is not a keyframe of the robot: {have}')
    key = alone.key(start)
    widths = {0: 7, 1: 4, 2: 1, 3: 1}
    for i in range(alone.njnt):
        begin = int(alone.jnt_qposadr[i])
        loaded.start[alone.joint(i).name] = key.qpos[begin : begin + widths[int(alone.jnt_type[i])]].copy()
    given = {name for name, _, _ in loaded.controls}
    for i in range(alone.nu):
        if (name := alone.actuator(i).name) not in given:
            loaded.controls.append((name, np.zeros(1), np.array([key.ctrl[i]])))


def place_joints(model: Any, robots: Sequence[LoadedRobot]) -> Array:
    """Return the positions of all joints at the start: those of the files, or of their keyframes."""
    mujoco = engine()
    positions = np.array(model.qpos0)
    for loaded in robots:
        R = rotation_matrix(np.radians(loaded.robot.rotation))
        for name, value in loaded.start.items():
            begin = int(model.joint(f"{loaded.name}.{name}").qposadr[0])
            if len(value) == 7:
                value = value.copy()
                value[:3] = np.array(loaded.robot.position) + product(R, value[:3])
                turned = np.zeros(4)
                mujoco.mju_mulQuat(turned, quaternion(R), value[3:].copy())
                value[3:] = turned
            positions[begin : begin + len(value)] = value
    return positions
