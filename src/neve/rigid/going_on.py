"""Go on in another scene: the rigid bodies stay where they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from neve.geometry.pose import rotation_vector
from neve.rigid.coupled_bodies import CoupledBodies
from neve.scene.schema.scene import Scene

START = ("center", "rotation", "velocity", "spin")
"""Keys of a rigid body that say where it begins."""
MOVED = ("bodies", "robots")
"""Lists of a scene that hold solids which snow moves."""


class HasBodies(Protocol):
    """What holds the solids of a scene, and who moves the bodies among them."""

    @property
    def rigid(self) -> CoupledBodies | None:
        """None without bodies."""


Placed = TypeVar("Placed", bound=HasBodies)


def going_on(scene: Scene, new_scene: Scene, placed: HasBodies, make: Callable[[Scene], Placed]) -> Placed:
    """Return `make` of `new_scene`, with the rigid bodies of `placed`, those of `scene`, where they are.

    Bodies keep place and motion, but those whose start `new_scene` changes begin there; where bodies or
    robots come, go or change, robots and bodies at joints begin anew.
    """
    if placed.rigid is None:
        return make(new_scene)
    if all(getattr(new_scene, name) == getattr(scene, name) for name in MOVED):
        fresh = make(new_scene)
        if fresh.rigid is not None:
            fresh.rigid.take_over(placed.rigid)
        return fresh
    return make(_started_there(scene, new_scene, placed.rigid))


def _started_there(scene: Scene, new_scene: Scene, rigid: CoupledBodies) -> Scene:
    """Return `new_scene` with its free bodies of the same start where those of `rigid` are."""
    poses = dict(zip((solid.name for solid in rigid.solids), rigid.poses(), strict=True))
    bodies = list(new_scene.bodies)
    for i, (old, new) in enumerate(zip(scene.bodies, new_scene.bodies, strict=False)):
        pose = poses.get(f"bodies.{i}")
        if pose is None or new.joint != "free" or any(getattr(old, k) != getattr(new, k) for k in START):
            continue
        bodies[i] = new.model_copy(
            update={
                "center": tuple(map(float, pose.position)),
                "rotation": tuple(map(float, np.degrees(rotation_vector(pose.rotation)))),
                "velocity": tuple(map(float, pose.velocity)),
                "spin": tuple(map(float, pose.omega)),
            }
        )
    return new_scene.model_copy(update={"bodies": tuple(bodies)})
