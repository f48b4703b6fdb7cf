"""Refuse bodies that begin inside one another: the engine would throw them apart."""

from __future__ import annotations

from typing import Any

from neve.scene.errors import SceneError

SHARE = 0.05
"""Of the smallest half extent of the smaller body: so deep two bodies may touch at the start."""


def require_apart(model: Any, data: Any) -> None:
    """Raise SceneError, one sentence that names both, if a body is inside another or inside a collider.

    The contacts of `data` are those of the start. Geoms of one robot may overlap one another.
    """
    for contact in data.contact:
        first, second = (int(geom) for geom in contact.geom)
        names = [model.geom(geom).name for geom in (first, second)]
        if _robot(names[0]) and _robot(names[0]) == _robot(names[1]):
            continue
        moving = [geom for geom in (first, second) if model.body_weldid[model.geom_bodyid[geom]] != 0]
        moving = [geom for geom in moving if model.body_mocapid[model.geom_bodyid[geom]] < 0]
        size = min((float(model.geom_aabb[geom, 3:].min()) for geom in moving), default=0.0)
        if -contact.dist > SHARE * size:
            raise SceneError(_sentence(model, names, (first, second), -float(contact.dist)))


def _sentence(model: Any, names: list[str], geoms: tuple[int, int], depth: float) -> str:
    from neve.rigid.engine import engine

    meshes = [model.geom_type[geom] == engine().mjtGeom.mjGEOM_MESH for geom in geoms]
    hull = "; bodies touch the convex hull of a mesh" if any(meshes) else ""
    bodies = [name for name in names if name.startswith("bodies.")]
    way_out = f", or set {bodies[-1]}.contacts = false" if bodies else ""
    both = " and ".join(sorted(names))
    return f"{both} are {depth:.3g} m inside one another at the start{hull}: move one{way_out}"


def _robot(name: str) -> str:
    """Return the robot that a geom belongs to, such as "robots.0"; "" if it belongs to none."""
    return ".".join(name.split(".")[:2]) if name.startswith("robots.") else ""
