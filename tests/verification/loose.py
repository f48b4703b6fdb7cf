"""Rigid bodies without snow: scenes whose only motion is that of the engine."""

import numpy as np

from neve.colliders.solid import solid_of
from neve.rigid.bodies import RigidBodies
from neve.scene.reading.load import scene_from

G = 9.81


def bodies_of(bodies, colliders=(), gravity=(0.0, 0.0, -G), robots=()):
    """The engine with these tables of `[[bodies]]`, `[[colliders]]` and `[[robots]]`."""
    scene = scene_from(
        {
            "sources": [{"shape": "box", "center": [0.0, 0.0, -50.0]}],
            "world": {"gravity": list(gravity)},
            "bodies": list(bodies),
            "colliders": list(colliders),
            "robots": list(robots),
        }
    )
    return RigidBodies(scene, [solid_of(c, f"colliders.{i}", 0.05) for i, c in enumerate(scene.colliders)])


def run(rigid, dt, steps, exchanged=None, done=0):
    """Advance by `steps` steps of dt, after `done` others, under the same exchange each; return the poses."""
    if exchanged is None:
        exchanged = np.zeros((len(rigid.solids), 7))
    for i in range(done, done + steps):
        rigid.advance(dt, exchanged, i * dt)
    return rigid.poses()


def exchange(*wrenches):
    """Impulses and moments, six numbers a solid, as rows of what `advance` takes."""
    return np.array([[*wrench, 0.0] for wrench in wrenches])
