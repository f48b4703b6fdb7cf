"""The view with which a page begins: that of the scene's camera at the start."""

import numpy as np
import pytest

from neve.build import solids
from neve.scene.reading.load import scene_from
from neve.viewer.describe import describe, drawn
from neve.viewer.players.player import Player
from neve.viewer.players.snapshot import Snapshot

BASE = {"sources": [{"shape": "sphere"}], "bodies": [{"shape": "box"}], "colliders": [{"shape": "plane"}]}


class Still(Player):
    """A player that shows one snapshot."""

    def solids(self):
        return solids(self.scene)

    def color_modes(self):
        return []

    def state(self):
        return {}


def seen(camera, snapshot=None):
    player = Still("still", scene_from({**BASE, "camera": camera}))
    player.latest = snapshot
    return describe(player)["camera"]


def test_a_page_begins_with_the_first_keyframe():
    """What the first keyframe says, the rest from the camera; a replay as well."""
    keys = [{"t": 0.0, "position": [1, -9, 4], "fov": 20}, {"t": 1.0, "fov": 60}]
    camera = seen({"keyframes": keys})
    assert (camera["position"], camera["target"], camera["fov"]) == ((1, -9, 4), (0, 0, 0.5), 20)
    scene = scene_from({**BASE, "camera": {"keyframes": keys}})
    assert drawn("", scene, solids(scene), [], 0.1)["camera"] == camera


@pytest.mark.parametrize(("follow", "target"), [("snow", (1, 2, 4)), ("bodies.0", (3, 0, 2))])
def test_a_page_begins_with_what_is_followed(follow, target):
    """Once there is a snapshot, what the camera follows is in the middle; until then its target."""
    assert seen({"follow": follow})["target"] == (0, 0, 0.5)
    poses = tuple((np.array(x, float), np.eye(3)) for x in ((0, 0, 0), (3, 0, 1)))
    snapshot = Snapshot(np.full((5, 3), (1.0, 2.0, 3.0), np.float32), {}, poses, 0.0, 0)
    found = seen({"follow": follow, "offset": [0, 0, 1]}, snapshot)
    assert found["target"] == pytest.approx(target)
