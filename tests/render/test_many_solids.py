"""Pictures of many solids: the tree over them leaves out what cannot matter, and nothing else."""

import numpy as np
import pytest

from neve import _render
from neve.build import solids
from neve.colliders.motion import pose
from neve.render.preview import Preview
from neve.scene.reading.load import scene_from

SIZE = (192, 108)
PLAIN = 10**6
"""Solids in a leaf: all in one, so that each ray and each point asks every solid."""


def crowd(seed, count=50):
    """A plane, two meshes, and boxes, balls and cylinders of all sizes before, around and behind the eye."""
    rng = np.random.default_rng(seed)
    colliders = [
        {"shape": "plane"},
        {"shape": "mesh", "file": "neve:rock", "center": [-1.0, 0.0, 0.4]},
        {"shape": "mesh", "file": "neve:pine", "center": [1.0, 1.0, 0.0], "velocity": [0.3, 0.0, 0.0]},
    ]
    for i in range(count):
        shape = ("box", "sphere", "cylinder")[i % 3]
        center = rng.uniform((-4.0, -8.0, 0.0), (4.0, 6.0, 2.0))
        size = float(np.exp(rng.uniform(np.log(0.01), np.log(1.0))))
        sizes = {
            "box": {"size": (size * rng.uniform(0.2, 2.0, 3)).tolist()},
            "sphere": {"radius": 0.5 * size},
            "cylinder": {"radius": 0.4 * size, "height": 2.0 * size},
        }[shape]
        turn = {} if shape == "sphere" else {"rotation": rng.uniform(-180.0, 180.0, 3).tolist()}
        motion = {"velocity": rng.uniform(-1.0, 1.0, 3).tolist()} if rng.random() < 0.4 else {}
        colliders.append({"shape": shape, "center": center.tolist(), **sizes, **turn, **motion})
    colliders.append(dict(colliders[3]))  # twice at one place: the first counts
    return scene_from(
        {
            "sources": [{"shape": "sphere"}],
            "colliders": colliders,
            "numerics": {"dx": 0.1},
            "camera": {"position": [0.0, -5.0, 1.5], "target": [0.0, 0.0, 0.5]},
            "light": {"sun_azimuth": 90.0 * seed, "sun_elevation": 15.0},
        }
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_a_picture_does_not_depend_on_the_tree_over_the_solids(seed, monkeypatch):
    scene = crowd(seed)
    x = np.random.default_rng(seed).uniform((-0.7, -0.7, 0.1), (0.7, 0.7, 0.8), (3000, 3)).astype(np.float32)
    one = _render.Painter

    def film(leaf):
        monkeypatch.setattr(_render, "Painter", lambda camera, light: one(camera, light, leaf))
        preview, found = Preview(scene, *SIZE), solids(scene)
        moments = [[pose(c, t) for c in scene.colliders] for t in (0.0, 0.1)]
        return [preview.draw(x, list(zip(found, poses, strict=True))) for poses in moments]

    plain = film(PLAIN)
    assert np.array_equal(film(1), plain)
    assert np.array_equal(film(4), plain)
    assert not np.array_equal(plain[0], plain[1])  # there is something to see
