"""Turn a scene into what every solver needs of it: solids with their bodies, and the material table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from neve.colliders.solid import Solid, solid_of
from neve.scene.checks.joined import joined_warnings
from neve.scene.schema.scene import Scene, Snow

if TYPE_CHECKING:
    from neve.rigid.coupled_bodies import CoupledBodies


def coupled(scene: Scene) -> tuple[tuple[Solid, ...], CoupledBodies | None]:
    """Return all that snow can meet, and who moves the rigid bodies among it, if there are any.

    The colliders come first, then the rigid bodies, in the order of the scene.

    Errors: SceneError for a mesh or a height map that cannot be used.
    """
    with joined_warnings():
        dx = scene.numerics.dx
        around = tuple(solid_of(c, f"colliders.{i}", dx) for i, c in enumerate(scene.colliders))
        if not (scene.bodies or scene.robots):
            return around, None
        from neve.rigid.bodies import RigidBodies

        rigid = RigidBodies(scene, around)
    return (*around, *rigid.solids), rigid


def solids(scene: Scene) -> tuple[Solid, ...]:
    """Return all that snow can meet: the colliders, then the bodies, in the order of the scene."""
    return coupled(scene)[0]


def material_table(scene: Scene) -> list[Snow]:
    """Return the different snows of the scene, in the order of their first source."""
    return list(dict.fromkeys(scene.snow_of(source) for source in scene.sources))
