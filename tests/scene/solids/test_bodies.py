"""Bodies in scenes: what a file may say about them, and the sentence for what it may not."""

import tomllib

import pytest

from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from, to_toml

SNOW = [{"shape": "box"}]


def scene(*bodies):
    """A scene with these tables of `[[bodies]]`."""
    return scene_from({"sources": SNOW, "bodies": list(bodies)})


def test_a_scene_is_written_and_read_back():
    """Every kind of body survives the way through TOML."""
    made = scene(
        {"shape": "box", "density": 400.0, "velocity": [1, 0, 0]},
        {"shape": "sphere", "mass": 3.0, "color": [1, 0, 0], "contacts": False},
        {"shape": "cylinder", "joint": "hinge", "axis": [0, 1, 0], "anchor": [0, 0, 1], "parent": 1,
         "limits": [-10.0, 20.0], "motor": {"kind": "position", "keyframes": [{"t": 1.0, "value": 3.0}]}},
    )  # fmt: skip
    assert scene_from(tomllib.loads(to_toml(made))) == made


HINGE = {"shape": "box", "joint": "hinge"}

WRONG = [
    ([{}], 'bodies.0 has no shape; add shape = "box", "sphere"'),
    ([{"shape": "bxo"}], 'bodies.0.shape = "bxo" is not allowed (did you mean "box"?)'),
    ([{"shape": "box", "frction": 1.0}], "bodies.0.frction is not a known key of a box (did you mean"),
    ([{"shape": "box", "mass": 0.0}], "bodies.0.mass = 0.0 is not allowed: use a number greater than 0"),
    ([{"shape": "box", "density": -1.0}], "bodies.0.density = -1.0 is not allowed: use a number greater"),
    ([{"shape": "box", "mass": 1.0, "density": 3.0}], "cannot be combined with mass; leave one of them out"),
    ([{"shape": "box", "motor": {}}], 'bodies.0.motor needs joint = "hinge"'),
    ([{"shape": "box", "limits": [0.0, 1.0]}], 'it needs joint = "hinge" or "slide"; a free body has none'),
    ([{**HINGE, "axis": [0, 0, 0]}], "it must not be the zero vector; [0, 0, 1] is upward"),
    ([{**HINGE, "limits": [10.0, 20.0]}], "it must hold the start, 0, and the first must be less than"),
    ([{**HINGE, "velocity": [1, 0, 0]}], 'it cannot be kept by joint = "hinge"; set spin along axis'),
    ([{**HINGE, "spin": [1, 0, 0]}], 'it must be along axis, the only way that joint = "hinge" leaves'),
    ([{**HINGE, "joint": "slide", "anchor": [0, 0, 0]}], 'is of no use to joint = "slide"; leave it out'),
    ([{**HINGE, "parent": 0}], "must be the number of an earlier body, and the first body has none"),
    ([{"shape": "box"}, {**HINGE, "parent": 3}], "bodies.1.parent = 3 is not allowed: it must be the number"),
    ([{**HINGE, "motor": {"kind": "torqe"}}], '(did you mean "torque"?): use "velocity", "position" or'),
    ([{**HINGE, "motor": {"kind": "torque", "gain": 2.0}}], 'is of no use to kind = "torque"'),
    ([{**HINGE, "motor": {"limit": 0.0}}], "bodies.0.motor.limit = 0.0 is not allowed: use a number"),
    (
        [{**HINGE, "motor": {"target": 1.0, "keyframes": [{"t": 0.0}]}}],
        "bodies.0.motor.target = 1.0 is not allowed: it cannot be combined with keyframes",
    ),
    (
        [{**HINGE, "motor": {"keyframes": [{"t": 1.0}, {"t": 1.0}]}}],
        "bodies.0.motor.keyframes.1.t = 1.0 is not allowed: it must be later than the keyframe before it",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("bodies", "sentence"), WRONG, ids=[sentence[:40] for _, sentence in WRONG])
def test_wrong_bodies_are_told_in_one_sentence(bodies, sentence):
    """One line that names the key, its value and what is allowed."""
    with pytest.raises(SceneError) as error:
        scene(*bodies)
    told = str(error.value)
    assert sentence in told
    assert "\n" not in told
