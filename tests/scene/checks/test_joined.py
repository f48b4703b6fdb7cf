"""Warnings that say the same of many parts become one sentence."""

import warnings

import pytest

from neve import Simulation
from neve.colliders.solid import solid_of
from neve.rigid.engine import _tell, forget
from neve.scene.checks.advice import advice
from neve.scene.checks.joined import MOST_ALIKE, joined, joined_warnings
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from


def thin(count):
    """A scene of so many plates, each of another thickness below two cells, far from the snow."""
    plates = [
        {"shape": "box", "center": [4.0 + i, 0.0, 0.0], "size": [0.01 + 1e-4 * i, 1.0, 1.0]}
        for i in range(count)
    ]
    return scene_from({"sources": [{"shape": "sphere"}], "colliders": plates, "numerics": {"dx": 0.1}})


def test_a_few_are_told_one_by_one_and_many_at_once():
    """The first sentence stands for all, with the count and the first names."""
    assert len(advice(thin(MOST_ALIKE))) == MOST_ALIKE
    (sentence,) = advice(thin(200))
    assert sentence.startswith("colliders.0.size makes this collider 0.01 m thin")
    assert sentence.endswith("(and likewise 199 others: colliders.1, colliders.2, colliders.3 and so on)")


def test_equal_sentences_are_said_once_with_their_number():
    """100 equal ones, and 100 that name other files."""
    assert joined(["the engine says so."] * 100 + ["another"]) == [
        "the engine says so (100 times)",
        "another",
    ]
    (said,) = joined(f'bodies.{i}.file = "/maps/rock {chr(97 + i)}.obj" has 3 holes' for i in range(20))
    assert said == (
        'bodies.0.file = "/maps/rock a.obj" has 3 holes (and likewise 19 others: bodies.1, bodies.2, '
        "bodies.3 and so on)"
    )


def test_sentences_of_another_kind_stay_apart_and_in_order():
    """Only numbers and the numbers of parts may differ."""
    said = [f"{name}.{i}.size is {i}.5 m" for i in range(5) for name in ("bodies", "sources")]
    both = joined([*said, "numerics.dt is long"])
    assert [one.partition(" (")[0] for one in both] == [
        "bodies.0.size is 0.5 m",
        "sources.0.size is 0.5 m",
        "numerics.dt is long",
    ]


def test_what_the_making_of_snow_and_solids_warns_of_is_joined():
    """Five balls that begin partly inside the ground: one warning."""
    balls = [{"shape": "sphere", "radius": 0.3, "center": [2.0 * i, 0.0, 0.1]} for i in range(5)]
    scene = scene_from({"sources": balls, "colliders": [{"shape": "plane"}], "numerics": {"dx": 0.1}})
    with pytest.warns(SceneWarning) as heard:
        Simulation(scene, threads=1)
    (said,) = {str(one.message) for one in heard}
    assert said.startswith("sources.0 starts with")
    assert said.endswith("(and likewise 4 others: sources.1, sources.2, sources.3 and so on)")


def test_what_bodies_and_robots_warn_of_is_joined(tmp_path, monkeypatch):
    """Six bodies that are doubtful, and six robots with a gravity of their own: two sentences."""

    def doubtful(part, name, dx):
        warnings.warn(f"{name} has 3 holes", SceneWarning, stacklevel=1)
        return solid_of(part, name, dx)

    monkeypatch.setattr("neve.rigid.bodies.solid_of", doubtful)
    robot = tmp_path / "robot.xml"
    robot.write_text(
        '<mujoco><option gravity="0 0 -1.62"/><worldbody><geom name="g" size=".1"/></worldbody></mujoco>'
    )
    bodies = [{"shape": "sphere", "radius": 0.2, "center": [float(i), 0.0, 5.0]} for i in range(6)]
    robots = [{"file": str(robot), "position": [float(i), 3.0, 0.0]} for i in range(6)]
    scene = scene_from(
        {"sources": [{"shape": "sphere"}], "bodies": bodies, "robots": robots, "numerics": {"dx": 0.1}}
    )
    with pytest.warns(SceneWarning) as heard:
        Simulation(scene, threads=1)
    said = [str(one.message) for one in heard]
    assert len(said) == 2, said
    assert all("(and likewise 5 others: " in one for one in said)


def test_what_the_engine_says_in_every_step_is_said_at_its_first_and_tenth_time(caplog):
    """MuJoCo warns anew in each step: the log has the 1st, the 10th and the 100th of a kind."""
    forget()
    for i in range(150):
        _tell(f"Inertia matrix is too close to singular at DOF 0. Time = {i * 0.01:.4f}.")
    assert [" (for the " in record.getMessage() for record in caplog.records] == [False, True, True]


def test_an_error_and_other_warnings_come_through():
    """The block hides nothing but what it repeats."""

    def warn_and_fail():
        with joined_warnings():
            warnings.warn("sources.0 is doubtful", SceneWarning, stacklevel=1)
            raise SceneError("sources.1 is wrong")

    with pytest.raises(SceneError, match=r"sources\.1 is wrong"):
        warn_and_fail()
    with pytest.warns(DeprecationWarning, match="old"), joined_warnings():
        warnings.warn("old", DeprecationWarning, stacklevel=1)
