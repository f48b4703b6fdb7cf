"""A small real run to export."""

import shutil

import pytest

from neve.io.frames import read_frame
from neve.run import painter, run_scene
from neve.scene.reading.load import load

SCENE = """
about = "A ball of snow on a plane, a plate that moves, a body"
[run]
duration = 0.16
fps = 25
[numerics]
dx = 0.2
[[sources]]
shape = "sphere"
center = [0.0, 0.0, 0.7]
radius = 0.4
velocity = [1.0, 0.5, -2.0]
[[colliders]]
shape = "plane"
[[colliders]]
shape = "box"
center = [2.0, 0.0, 0.5]
size = [0.6, 1.0, 1.4]
rotation = [0.0, 0.0, 30.0]
velocity = [-1.0, 0.0, 0.0]
[[bodies]]
shape = "sphere"
center = [-1.5, 0.0, 1.0]
radius = 0.3
"""


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A run of frames 0 to 4, which no test may change."""
    place = tmp_path_factory.mktemp("exported")
    (place / "scene.toml").write_text(SCENE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(painter, "SIZE", (64, 36))
        run_scene(load(place / "scene.toml", ["run.film=false"]), place / "run", threads=1, quiet=True)
    return place / "run"


@pytest.fixture
def run_path(finished, tmp_path):
    """A copy of the run."""
    return shutil.copytree(finished, tmp_path / "run")


@pytest.fixture
def frame(finished):
    """Read a frame of the run."""
    return lambda number: read_frame(finished / "frames", number)
