"""Bodies that begin inside one another are refused in one sentence that names both."""

import pytest
from verification.loose import bodies_of

from neve.scene.errors import SceneError

BALL = {"shape": "sphere", "radius": 0.2, "center": [0.0, 0.0, 0.5]}
CASES = [
    ([BALL, {"shape": "box", "size": [1, 1, 1], "center": [0.5, 0.1, 0.5]}], [], "bodies.0 and bodies.1"),
    ([BALL, {**BALL, "radius": 0.1}], [], "bodies.0 and bodies.1"),
    ([BALL], [{"shape": "plane", "point": [0, 0, 0.35]}], "bodies.0 and colliders.0 are 0.05 m inside"),
    ([BALL], [{"shape": "cylinder", "radius": 1.0, "height": 3.0}], "bodies.0 and colliders.0"),
    ([BALL], [{"shape": "box", "size": [3, 3, 3], "velocity": [1, 0, 0]}], "bodies.0 and colliders.0"),
]


@pytest.mark.parametrize(("bodies", "colliders", "both"), CASES)
def test_inside_one_another(bodies, colliders, both):
    """Whole or in part inside, bodies and colliders, resting or moving."""
    with pytest.raises(SceneError) as error:
        bodies_of(bodies, colliders)
    told = str(error.value)
    assert both in told
    last = f"bodies.{len(bodies) - 1}"
    assert told.endswith(f"inside one another at the start: move one, or set {last}.contacts = false.")


@pytest.mark.parametrize(("bodies", "colliders", "both"), CASES)
def test_without_contacts_they_may(bodies, colliders, both):
    """Bodies that meet nobody may be anywhere."""
    bodies_of([{**body, "contacts": False} for body in bodies], colliders)


def test_touching_is_no_overlap():
    """A ball on a plane, boxes side by side, a wheel and the body that carries it may touch or overlap."""
    bodies_of([BALL], [{"shape": "plane", "point": [0, 0, 0.3]}])
    side = {"shape": "box", "size": [1, 1, 1], "center": [1.0, 0, 0.5]}
    bodies_of([{**side, "center": [0.0, 0, 0.5]}, side], [{"shape": "plane"}])
    wheel = {"shape": "cylinder", "radius": 0.3, "height": 0.2, "center": [0.9, 0, 0.5]}
    bodies_of([side, {**wheel, "joint": "hinge", "parent": 0}])
