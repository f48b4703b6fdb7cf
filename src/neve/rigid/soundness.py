"""Whether the engine can move what it was given: finite sizes, inertia that every joint has, bodies apart."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.rigid.engine import engine
from neve.scene.errors import SceneError

MOST_SOLIDS = 300
"""Solids that may move: their joint mobility is a dense matrix of six rows for each."""
MOST_FREEDOM = 1500
"""Degrees of freedom of all bodies and robots: their joint inertia is a dense matrix, too."""
LARGEST = 1e6
"""Largest distance of a geom's surface from its own centre [m], as for the shapes of a scene."""
SHARE = 0.05
"""Of the smallest half extent of the smaller body: so deep two bodies may touch at the start."""
SINGULAR = 1e-13
"""Least pivot of the inertia of joints, scaled to a diagonal of ones, that equations still bear."""


def require_few(model: Any, solids: int) -> None:
    """Refuse more bodies than the dense matrices of bodies in snow can bear.

    Errors: SceneError, one sentence.
    """
    for count, most, what in (
        (solids, MOST_SOLIDS, "solids that move"),
        (model.nv, MOST_FREEDOM, "degrees of freedom"),
    ):
        if count > most:
            raise SceneError(
                f"bodies and robots have {count:,} {what}: {most:,} are allowed, because snow and bodies "
                "find their velocities together"
            )


def require_movable(model: Any, data: Any) -> None:
    """Refuse geoms that are too large, and joints that nothing gives inertia.

    Errors: SceneError, one sentence that names the geom or the body.
    """
    for geom in range(model.ngeom):
        reach = float(model.geom_rbound[geom])  # 0 for a plane, which has no end
        if not reach <= LARGEST:
            raise SceneError(
                f"{_geom_name(model, geom)} is {reach:.3g} m large: {LARGEST:g} m are allowed from its centre"
            )
    if not model.nv:
        return
    inertia = np.zeros((model.nv, model.nv))
    engine().mj_fullM(model, data, inertia)
    if (dof := _without_inertia(inertia)) is not None:
        body = body_name(model, int(model.dof_bodyid[dof]))
        raise SceneError(
            f"{body} cannot be moved: the joints that carry it have no inertia of their own, or one that is "
            "too small beside that of others: check masses and sizes"
        )


def _geom_name(model: Any, geom: int) -> str:
    return model.geom(geom).name or f"a geom of {body_name(model, int(model.geom_bodyid[geom]))}"


def body_name(model: Any, body: int) -> str:
    """Return the name of a body, or of its first geom that has one, or its number."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    names = [model.body(body).name, *(model.geom(geom).name for geom in range(first, first + count))]
    return next(filter(None, names), f"body {body} of the robots")


def _without_inertia(inertia: NDArray[np.float64]) -> int | None:
    """Return a degree of freedom that the others leave no inertia; None if the matrix can be inverted."""
    diagonal = np.diag(inertia)
    if not np.isfinite(inertia).all() or not (diagonal > 0.0).all():
        return int(np.argmin(np.where(np.isfinite(diagonal), diagonal, -np.inf)))
    scale = 1.0 / np.sqrt(diagonal)
    factor = inertia * scale[:, None] * scale
    rank = engine().mju_cholFactor(factor, SINGULAR)
    return None if rank == len(scale) else int(np.argmin(np.diag(factor)))


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
    meshes = [model.geom_type[geom] == engine().mjtGeom.mjGEOM_MESH for geom in geoms]
    hull = "; bodies touch the convex hull of a mesh" if any(meshes) else ""
    bodies = [name for name in names if name.startswith("bodies.")]
    way_out = f", or set {bodies[-1]}.contacts = false" if bodies else ""
    both = " and ".join(sorted(names))
    return f"{both} are {depth:.3g} m inside one another at the start{hull}: move one{way_out}"


def _robot(name: str) -> str:
    """Return the robot that a geom belongs to, such as "robots.0"; "" if it belongs to none."""
    return ".".join(name.split(".")[:2]) if name.startswith("robots.") else ""
