"""Read robots and vehicles from MJCF and URDF files, and put them into the engine's model."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from neve.geometry.pose import rotation_matrix
from neve.reproducible import product
from neve.rigid.engine import engine, quaternion, reason
from neve.scene.errors import SceneError
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

    Its own options, such as gravity and time step, do not count: those of the scene do.

    Errors: SceneError, one sentence: unreadable, a mesh that is missing, nothing that collides, flexible
    parts, no such actuator, keyframe or range.
    """
    text = f"{name}.file = {json.dumps(robot.file, ensure_ascii=False)}"
    child = _read(Path(robot.file), text)
    is_urdf = _is_urdf(Path(robot.file))
    if is_urdf:
        _find_meshes(child, Path(robot.file).parent, text)
        child.compiler.fusestatic = False
    if robot.free:
        _set_free(child, name)
    loaded = LoadedRobot(name, robot, _named_geoms(child, text))
    _name_joints_and_actuators(child)
    if is_urdf:
        loaded.motors = _motors(child, robot)
    alone = _compiled(child, text)
    _check_controls(loaded, alone)
    _set_start(loaded, alone)
    for key in list(child.keys):
        child.delete(key)
    for option in (o for o in dir(spec.option) if not o.startswith("_")):
        setattr(child.option, option, getattr(spec.option, option))
    R = rotation_matrix(np.radians(robot.rotation))
    frame = spec.worldbody.add_frame(pos=robot.position, quat=quaternion(R))
    spec.attach(child, prefix=f"{name}.", frame=frame)
    return loaded


def files_of(path: Path) -> list[Path]:
    """Return the files that the robot file `path` names and that are there: meshes, textures, includes."""
    try:
        if not _is_urdf(path):
            return [Path(name) for name in engine().mju_getXMLDependencies(str(path)) if Path(name).is_file()]
        names = [mesh.get("filename", "") for mesh in ElementTree.parse(path).iter("mesh")]
    except (ElementTree.ParseError, OSError, ValueError, engine().FatalError):
        return []
    found = (_mesh_file(name, path.parent) for name in names)
    return [file for file in dict.fromkeys(found) if file]


def _is_urdf(path: Path) -> bool:
    """Tell whether the root of an XML file is that of a URDF file."""
    try:
        for _, element in ElementTree.iterparse(path, events=("start",)):
            return bool(element.tag == "robot")
    except (ElementTree.ParseError, OSError):
        pass
    return False


def _read(path: Path, text: str) -> Any:
    try:
        return engine().MjSpec.from_file(str(path))
    except (ValueError, OSError, engine().FatalError) as error:
        raise SceneError(f"{text} cannot be read as a robot: {reason(error)}") from None


def _compiled(child: Any, text: str) -> Any:
    try:
        model = child.compile()
    except (ValueError, OSError, engine().FatalError) as error:
        raise SceneError(f"{text} cannot be used as a robot: {reason(error)}") from None
    if model.nflex:
        raise SceneError(f"{text} has flexible parts (flex), which bodies of Neve are not: take them out")
    return model


def _find_meshes(child: Any, folder: Path, text: str) -> None:
    """Make the names of the meshes of a URDF file, seen from its `folder`, absolute."""
    for mesh in child.meshes:
        found = _mesh_file(mesh.file, folder)
        if found is None:
            missing = json.dumps(mesh.file, ensure_ascii=False)
            raise SceneError(f"{text} names a mesh {missing} that is neither beside the file nor above it")
        mesh.file = str(found)


def _mesh_file(name: str, folder: Path) -> Path | None:
    """Return the file that a URDF file in `folder` calls `name`: a path, or package://PACKAGE/PATH."""
    scheme, _, rest = name.rpartition(":/")
    bare = Path(rest.lstrip("/") if scheme else name)
    if scheme == "file":
        bare = Path("/") / bare
    folder = folder.resolve()
    candidates = [folder / bare]
    if scheme in ("package", "model"):
        inside = Path(*bare.parts[1:]) if len(bare.parts) > 1 else bare
        candidates = [up / end for up in (folder, *folder.parents) for end in (bare, inside)]
    return next((path for path in candidates if path.is_file()), None)


def _set_free(child: Any, name: str) -> None:
    bases = list(child.worldbody.bodies)
    for base in bases:
        if base.joints:
            raise SceneError(
                f'{name}.free = true is not allowed: the base "{base.name}" has a joint in its file'
            )
        base.add_freejoint()


def _named_geoms(child: Any, text: str) -> list[str]:
    """Return the names of all geoms that collide; those without one are named after their body."""
    taken = {geom.name for geom in child.geoms}
    names = []
    for geom in child.geoms:
        if not (geom.contype or geom.conaffinity):
            continue
        if not geom.name:
            geom.name = _free_name(geom.parent.name or "geom", taken)
        names.append(geom.name)
    if not names:
        raise SceneError(f"{text} has no geometry that collides, so that snow would never meet it")
    return names


def _free_name(wanted: str, taken: set[str]) -> str:
    """Return `wanted`, with the first free number if it is taken, and add it to `taken`."""
    numbered = (f"{wanted}{i}" for i in itertools.count(1))
    name = wanted if wanted not in taken else next(other for other in numbered if other not in taken)
    taken.add(name)
    return name


def _name_joints_and_actuators(child: Any) -> None:
    joints, actuators = (
        {element.name for element in elements} for elements in (child.joints, child.actuators)
    )
    for joint in child.joints:
        joint.name = joint.name or _free_name(f"{joint.parent.name}_joint", joints)
    for actuator in child.actuators:
        actuator.name = actuator.name or _free_name(actuator.target or "actuator", actuators)


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
