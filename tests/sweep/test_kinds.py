"""Runs of a sweep whose logs have other columns than those of most scenes."""

import math

import pytest

from neve.io.run_folder import RunFolder
from neve.scene.reading.load import load, to_toml
from neve.sweep.measures import check, kinds, read_measure, usual
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
    measures = [*usual([scene]), read_measure("worst=solve_residual@max")]
    row = row_of(tmp_path / "0001", scene, measures)
    assert (row.status, row.sentence) == ("done", "")
    assert row.outputs["solve_iterations"] > 0
    assert math.isfinite(row.outputs["worst"])


def test_columns_that_a_method_lacks(ball, tmp_path):
    """They are empty in its rows, and so is a solid that a scene lacks; those of its own are there."""
    scenes = [load(ball, []), load(ball, ['numerics.method="particles"'])]
    measures = usual(kinds([*scenes, *scenes]))
    names = {measure.name for measure in measures}
    assert len(kinds([*scenes, *scenes])) == 2
    check(measures, scenes)
    run = RunFolder(tmp_path)
    assert "blocks" in names
    assert math.isnan(read_measure("blocks").of(run, scenes[1]))
    assert math.isnan(read_measure("push=force_z[colliders.9]").of(run, scenes[0]))
