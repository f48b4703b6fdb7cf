"""Read robot files with the engine's parser, and make sure that the engine can move what they hold."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from neve.rigid.engine import engine, heard, reason
from neve.rigid.robot_files.names import MOST_GEOMS, follow
from neve.rigid.soundness import MOST_SOLIDS, body_name, require_movable
from neve.scene.errors import SceneError


def read(path: Path, text: str) -> tuple[Any, list[str]]:
    """Read the robot file `path`; return the engine's model of it, and the names of geoms that collide.

    `text`: the begin of sentences. Meshes of URDF files are found; geoms that collide have names.

    Errors: SceneError, one sentence: unreadable, a mesh that is missing, nothing or too much that collides.
    """
    if is_urdf(path):
        _require_links(path, text)
    try:
        with heard():
            child = engine().MjSpec.from_file(str(path))
    except (ValueError, OSError, MemoryError, engine().FatalError) as error:
        raise SceneError(f"{text} cannot be read as a robot: {reason(error)}") from None
    if is_urdf(path):
        _find_meshes(child, path, text)
        child.compiler.fusestatic = False
    return child, _named_geoms(child, text)


def compiled(child: Any, text: str) -> Any:
    """Return the engine's compiled model of a robot.

    Errors: SceneError, one sentence: what the engine says, or flexible parts.
    """
    try:
        with heard():
            model = child.compile()
    except (ValueError, OSError, MemoryError, engine().FatalError) as error:
        raise SceneError(f"{text} cannot be used as a robot: {reason(error)}") from None
    if model.nflex:
        raise SceneError(f"{text} has flexible parts (flex), which bodies of Neve are not: take them out")
    return model


def examine(path: Path, text: str) -> list[str]:
    """Read, compile and move a robot once, and return the files that it names and that are there.

    Whatever the engine's parser does to the process: `neve.rigid.robot_files.helper` calls this in another.

    Errors: SceneError, one sentence.
    """
    follow(path, text)
    child, _ = read(path, text)
    model = compiled(child, text)
    if model.ngeom > MOST_GEOMS:
        raise SceneError(f"{text} has {model.ngeom:,} geoms: {MOST_GEOMS:,} are allowed")
    mujoco = engine()
    data = mujoco.MjData(model)
    try:
        mujoco.mj_step(model, data)
    except (ValueError, MemoryError, engine().FatalError) as error:
        raise SceneError(f"{text} cannot be used as a robot: {reason(error)}") from None
    if (name := _lost(model, data)) is not None:
        _require_movable(model, text)
        raise SceneError(
            f'{text} cannot be used as a robot: "{name}" has no finite place or velocity after its first step'
        )
    return [str(file) for file in _files(path)]


def _lost(model: Any, data: Any) -> str | None:
    """Return the name of the first body that is nowhere, or whose size or speed is no number."""
    for i in range(model.nbody):
        geoms, dofs, joints = (
            slice(int(first[i]), int(first[i]) + int(count[i]))
            for first, count in (
                (model.body_geomadr, model.body_geomnum),
                (model.body_dofadr, model.body_dofnum),
                (model.body_jntadr, model.body_jntnum),
            )
        )
        positions = [data.joint(k).qpos for k in range(joints.start, joints.stop)]
        numbers = (data.xpos[i], data.xmat[i], data.qvel[dofs], *positions, model.geom_size[geoms])
        shown = (data.geom_xpos[geoms], data.geom_xmat[geoms], model.geom_rgba[geoms])
        if not all(np.isfinite(part).all() for part in (*numbers, *shown)):
            return body_name(model, i)
    return None if np.isfinite(data.act).all() else "an actuator"


def _require_movable(model: Any, text: str) -> None:
    """Say why a robot cannot be moved, if its sizes or its inertia tell.

    Errors: SceneError.
    """
    data = engine().MjData(model)
    engine().mj_forward(model, data)
    try:
        require_movable(model, data)
    except SceneError as error:
        raise SceneError(f"{text} cannot be used as a robot: {error}") from None


def _files(path: Path) -> list[Path]:
    """Return the files that the robot file `path` names and that are there: meshes, textures, includes."""
    if not is_urdf(path):
        return [Path(name) for name in engine().mju_getXMLDependencies(str(path)) if Path(name).is_file()]
    names = [mesh.get("filename", "") for mesh in ElementTree.parse(path).iter("mesh")]
    found = (_mesh_file(name, path.parent) for name in names)
    return [file for file in dict.fromkeys(found) if file]


def is_urdf(path: Path) -> bool:
    """Tell whether the root of an XML file is that of a URDF file."""
    try:
        for _, element in ElementTree.iterparse(path, events=("start",)):
            return bool(element.tag == "robot")
    except (ElementTree.ParseError, OSError, ValueError):
        pass
    return False


def _require_links(path: Path, text: str) -> None:
    """Refuse joints of a URDF file between links that it does not have: the engine does not name them.

    Errors: SceneError.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError, ValueError):
        return  # left to the engine
    links = {link.get("name") for link in root.findall("link")}
    for joint in root.findall("joint"):
        for end in ("parent", "child"):
            found = joint.find(end)
            name = None if found is None else found.get("link")
            if name not in links:
                what = f"has no {end}" if name is None else f'names "{name}", which is no link of it'
                raise SceneError(f'{text} cannot be read as a robot: the joint "{joint.get("name")}" {what}')


def _find_meshes(child: Any, path: Path, text: str) -> None:
    """Make the names of the meshes of the URDF file `path`, seen from its folder, absolute."""
    for mesh in child.meshes:
        found = _mesh_file(mesh.file, path.parent)
        if found is None:
            missing = json.dumps(mesh.file, ensure_ascii=False)
            link = _link_of(mesh.file, path)
            named = f" of the link {json.dumps(link, ensure_ascii=False)}" if link else ""
            raise SceneError(
                f"{text} names a mesh {missing}{named} that is neither beside the file nor above it"
            )
        mesh.file = str(found)


def _link_of(name: str, path: Path) -> str:
    """Return the first link of the URDF file `path` with a mesh of the file `name`, or ""."""
    for link in ElementTree.parse(path).getroot().findall("link"):
        if any(Path(mesh.get("filename", "")).name == Path(name).name for mesh in link.iter("mesh")):
            return link.get("name", "")
    return ""


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
    try:
        return next((path for path in candidates if path.is_file()), None)
    except (OSError, ValueError):  # a name that no file can have
        return None


def _named_geoms(child: Any, text: str) -> list[str]:
    """Return the names of all geoms that collide; those without one are named after their body."""
    taken = {geom.name for geom in child.geoms}
    names = []
    for geom in child.geoms:
        if not (geom.contype or geom.conaffinity):
            continue
        if not geom.name:
            geom.name = free_name(geom.parent.name or "geom", taken)
        names.append(geom.name)
    if not names:
        raise SceneError(f"{text} has no geometry that collides, so that snow would never meet it")
    if len(names) > MOST_SOLIDS:
        raise SceneError(
            f"{text} has {len(names):,} geoms that collide: {MOST_SOLIDS:,} are allowed; let only those "
            "collide that snow meets (contype and conaffinity)"
        )
    return names


def free_name(wanted: str, taken: set[str]) -> str:
    """Return `wanted`, with the first free number if it is taken, and add it to `taken`."""
    if wanted in taken:
        numbered = (f"{wanted}{i}" for i in itertools.count(1))
        wanted = next(other for other in numbered if other not in taken)
    taken.add(wanted)
    return wanted
