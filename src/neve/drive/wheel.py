"""The wheel of a run: which body it is, how large it is, and which way it rolls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve.build import placed_at_start
from neve.geometry.mesh import read_mesh
from neve.io.errors import RunError
from neve.reproducible import norms, product
from neve.scene.schema.bodies import Body
from neve.scene.schema.file_shapes import Mesh
from neve.scene.schema.scene import Scene
from neve.scene.schema.shapes import Cylinder

Array = NDArray[np.float64]

LEVEL = 0.1
"""Sine of the slope up to which the axle of a wheel may lean."""


@dataclass(frozen=True)
class Wheel:
    """Hold what a wheel is.

    name: in `solids.csv`. row: among the solids of a frame. radius, width [m].
    axle: in the axes of its own frame [1], (3,). middle: of the wheel in its own frame [m], (3,).
    """

    name: str
    row: int
    radius: float
    width: float
    axle: Array
    middle: Array


def wheel_of(scene: Scene, name: str | None) -> Wheel:
    """Return the wheel of a scene: the body `name`, or the only one that turns about a level axle.

    Errors: RunError: there is none, there are several, or that body is no wheel.
    """
    bodies = {f"bodies.{number}": body for number, body in enumerate(scene.bodies)}
    wheels = [key for key, body in bodies.items() if _is_wheel(body)]
    if name is not None and name not in wheels:
        raise RunError(
            f"--wheel {name} is no wheel of the run, a cylinder or mesh on a hinge with a level axis: "
            f"it has {', '.join(wheels) or 'none'}."
        )
    if name is None and len(wheels) != 1:
        found = f"several ({', '.join(wheels)}): choose one by --wheel" if wheels else "none"
        raise RunError(
            "a fit needs a run with a wheel, a cylinder or mesh on a hinge with a level axis, and this one "
            f"has {found}."
        )
    name = name or wheels[0]
    number = len(scene.colliders) + list(bodies).index(name)
    _, pose = placed_at_start(scene)[number]
    axis = np.array(bodies[name].axis) / norms(np.array([bodies[name].axis]))[0]
    axle = product(pose.rotation.T, axis)
    radius, width, middle = _measures(bodies[name], axle, name)
    return Wheel(name, number, radius, width, axle, middle)


def _is_wheel(body: Body) -> bool:
    if body.joint != "hinge" or not isinstance(body, Mesh | Cylinder):
        return False
    axis = np.array(body.axis)
    return bool(abs(axis[2]) <= LEVEL * float(norms(axis[None])[0]))


def _measures(body: Body, axle: Array, name: str) -> tuple[float, float, Array]:
    """Return radius and width [m], and the middle in the own frame [m]."""
    if isinstance(body, Cylinder):
        return float(body.radius), float(body.height), np.zeros(3)
    assert isinstance(body, Mesh)
    corners = read_mesh(body, name).vertices
    along = product(corners, axle)
    across = corners - along[:, None] * axle
    centre = 0.5 * (across.min(axis=0) + across.max(axis=0))
    radius = float(norms(across - centre).max())
    return radius, float(np.ptp(along)), centre + 0.5 * (along.min() + along.max()) * axle
