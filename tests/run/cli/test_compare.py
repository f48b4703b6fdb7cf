"""`neve compare`: the same scene by each method, side by side."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from neve.cli import main
from neve.compare.film import FILM, PANEL, STILL, _joined
from neve.compare.page import PAGE
from neve.compare.run import TABLE, chosen_methods
from neve.io.errors import RunError
from neve.io.frames import frame_numbers, read_frame
from neve.registry import METHODS

SCENE = """
about = "A ball falls & breaks."
[numerics]
dx = 0.1
[[sources]]
shape = "sphere"
center = [0.0, 0.0, 0.3]
radius = 0.2
velocity = [0.0, 0.0, -3.0]
[[colliders]]
shape = "plane"
[run]
duration = 0.1
"""
SINK = """
[[sinks]]
shape = "box"
center = [5.0, 0.0, 0.0]
size = [1.0, 1.0, 1.0]
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return str(path)


def neve(*words):
    """Run a command; return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(list(words))
    return ended.value.code


def test_every_method_runs_on_one_clock(scene, tmp_path, capsys):
    """Each method of the registry has a run folder with frames of the same times, a row, and a panel."""
    out = tmp_path / "out"
    assert neve("compare", scene, "--out", str(out), "--quiet", "--threads", "1") in (0, None)
    times = {
        method: [read_frame(out / method / "frames", k).time for k in frame_numbers(out / method / "frames")]
        for method in METHODS.names()
    }
    assert all(value == times["mpm"] for value in times.values())
    rows = list(csv.DictReader((out / TABLE).read_text().splitlines()))
    assert [row["method"] for row in rows] == list(METHODS.names())
    masses = [float(row["mass [kg]"]) for row in rows]
    assert masses == pytest.approx([masses[0]] * len(rows), rel=1e-6)
    for row in rows:
        assert float(row["lost [J]"]) > 0
        assert int(row["steps"]) > 0
    page = (out / PAGE).read_text()
    assert "A ball falls &amp; breaks." in page
    assert FILM in page
    assert (out / FILM).stat().st_size > 1000
    with Image.open(out / STILL) as still:
        assert still.size == (2 * PANEL[0], math.ceil(len(rows) / 2) * PANEL[1])


def test_method_that_refuses_is_told(scene, tmp_path, capsys):
    """A scene with a sink: the method that has none is named with its sentence, the other one runs."""
    out = tmp_path / "out"
    Path(scene).write_text(SCENE + SINK)
    options = ("--quiet", "--threads", "1", "--frames", "1")
    assert neve("compare", scene, "--out", str(out), *options) in (0, None)
    assert "sph" not in [line.split(",")[0] for line in (out / TABLE).read_text().splitlines()]
    assert "adds and removes no snow" in (out / PAGE).read_text()
    assert neve("compare", scene, "--out", str(out), "--methods", "sph", "--force", *options) == 2


def test_bad_methods_are_refused():
    """One sentence for a word that is no method, and for one that is named twice."""
    with pytest.raises(
        RunError, match=r'--methods: numerics\.method = "sph2" is not allowed: use one of mpm'
    ):
        chosen_methods("mpm, sph2")
    with pytest.raises(RunError, match="twice"):
        chosen_methods("mpm,mpm")


def test_three_panels_make_two_rows():
    """A third method comes below the first; what is left over is black."""
    panels = [np.full((4, 6, 3), value, np.uint8) for value in (10, 20, 30)]
    joined = _joined(panels)
    assert joined.shape == (8, 12, 3)
    assert joined[5, 1, 0] == 30
    assert joined[5, 8, 0] == 0
