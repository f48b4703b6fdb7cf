"""Runs of a sweep whose logs have other columns than those of most scenes."""

import math

import pytest

from neve.scene.reading.load import load, to_toml
from neve.sweep.measures import read_measure, usual
from neve.sweep.task import Task, carry_out

SCENE = """
[numerics]
dx = 0.1
[[sources]]
shape = "sphere"
center = [0.0, 0.0, 0.15]
radius = 0.12
[[colliders]]
shape = "plane"
[run]
duration = 0.02
fps = 100
film = false
"""


@pytest.fixture
def ball(tmp_path):
    """Return the path of a small scene."""
    (tmp_path / "ball.toml").write_text(SCENE)
    return tmp_path / "ball.toml"


def row_of(folder, scene, measures):
    """Do one run of a sweep in this process."""
    return carry_out(Task(folder, {}, to_toml(scene), tuple(measures), threads=1))


def test_an_implicit_scene(ball, tmp_path):
    """Columns of implicit steps are there, unless told and by name."""
    scene = load(ball, ['numerics.integrator="semi_implicit"'])
    measures = [*usual(scene), read_measure("worst=solve_residual@max")]
    row = row_of(tmp_path / "0001", scene, measures)
    assert (row.status, row.sentence) == ("done", "")
    assert row.outputs["solve_iterations"] > 0
    assert math.isfinite(row.outputs["worst"])
