"""The way back: the snow that a run has left is part of the cover, and goes on in a next run."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import neve
from neve.cli.commands import cli
from neve.run.snowfall import snow_on
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, scene_from

BLOCK = {
    "numerics": {"dx": 0.1},
    "snow": {"kind": "packed"},
    "sources": [{"shape": "box", "size": [0.8, 0.8, 0.4], "center": [0, 0, 0.21], "structure": "plain"}],
    "colliders": [{"shape": "plane", "mu_c": 1.0}],
    "bodies": [{"shape": "sphere", "radius": 0.1, "center": [1.0, 0.0, 0.101], "velocity": [0.2, 0.0, 0.0]}],
    "run": {"duration": 0.2, "film": False, "fps": 10},
}


@pytest.fixture(scope="module")
def snowed(tmp_path_factory):
    """A run of a block of snow, and the folder of the snow that fell on it afterwards."""
    folder = tmp_path_factory.mktemp("runs")
    before = neve.Simulation(scene_from(BLOCK)).run(folder / "block", quiet=True)
    cover, out = snow_on(
        str(folder / "block"),
        str(folder / "snow"),
        options={"depth": 0.2, "density": 100.0, "size": (2.0, 2.0)},
    )
    return before, cover, out


def test_it_snows_on_what_a_run_left(snowed):
    """The new snow lies on the block, as high as its snow is, and beside it on the ground."""
    before, cover, _ = snowed
    over = np.all(np.abs(cover.x[:, :2]) < 0.25, axis=1)
    under = over & (cover.z < 0.2)  # the ground, where the block stands some millimetres above it
    assert cover.depth[under].sum() < 1e-3 * cover.depth.sum()
    over &= ~under
    height = np.asarray(before.state.x)[:, 2].max()
    assert np.abs(cover.z[over] - height).max() < 0.06
    assert np.median(cover.depth[over]) == pytest.approx(0.2, abs=0.03)
    aside = np.all(np.abs(cover.x[:, :2]) > 0.7, axis=1)
    assert np.abs(cover.z[aside]).max() < 1e-6


def test_books_of_both_snows(snowed):
    """What fell lies, missed or slid; the run's snow has its mass, and the volume it had to 2 %."""
    before, _, out = snowed
    books = json.loads((out / "books.json").read_text())
    assert books["fell"] == pytest.approx(books["lies"] + books["missed"] + books["slid"], abs=1e-12)
    assert books["resting_mass"] == pytest.approx(float(before.state.m.sum()), rel=1e-6)
    assert books["resting_volume"] == pytest.approx(0.8 * 0.8 * 0.4, rel=0.02)


def test_a_next_run_has_both_snows(snowed):
    """The mass of both; old particles lie where they lay with their J_P, and the ball where it rolled.

    A sphere that slides comes to roll at 5/7 of its speed, within 0.02 s here.
    """
    before, cover, out = snowed
    scene = load(out / "scene.toml")
    after = neve.Simulation(scene).state
    old = np.asarray(before.state.x)
    m = float(before.state.m.sum())
    assert float(after.m.sum()) == pytest.approx(m + cover.mass, rel=0.01)
    first = np.argsort(np.asarray(after.id))[: len(old)]
    order = np.argsort(np.asarray(before.state.id))
    assert np.abs(np.asarray(after.x)[first] - old[order]).max() < 1e-6
    assert np.abs(np.asarray(after.J_P)[first] - np.asarray(before.state.J_P)[order]).max() < 1e-6
    assert scene.bodies[0].center[0] == pytest.approx(1.0 + 5 / 7 * 0.2 * 0.2, abs=2e-3)
    assert scene.bodies[0].velocity == (0.0, 0.0, 0.0)


def test_another_ball_flies(snowed, tmp_path):
    """A ball thrown at the snowed block goes on in it, and both snows take its momentum."""
    _, _, out = snowed
    scene = load(out / "scene.toml")
    ball = {
        "shape": "sphere",
        "radius": 0.15,
        "center": [-1.0, 0.0, 0.35],
        "velocity": [8.0, 0.0, 0.0],
        "mass": 5.0,
    }
    data = scene.model_dump(mode="json", exclude_none=True)
    run = neve.Simulation(scene_from({**data, "bodies": [ball]}))
    momentum = float(np.sum(np.asarray(run.state.m) * np.asarray(run.state.v)[:, 0]))
    assert momentum == 0.0
    run.advance(0.15)
    assert np.isfinite(np.asarray(run.state.x)).all()
    old = np.asarray(run.state.material) == 0
    for mine in (old, ~old):
        assert float(np.sum(np.asarray(run.state.m)[mine] * np.asarray(run.state.v)[mine, 0])) > 0.1


def test_command_takes_a_run(snowed, tmp_path):
    """`neve snow RUN` writes all six files, twice the same bytes; --set is refused in one sentence."""
    _, _, out = snowed
    run = str(out.parent / "block")
    for name in ("a", "b"):
        words = ["snow", run, "--out", str(tmp_path / name), "--depth", "0.05", "--size", "1,1", "--quiet"]
        assert CliRunner().invoke(cli, words).exit_code == 0
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert names == ["books.json", "cover.npz", "depth.csv", "rest.npz", "scene.toml", "snow.ply"]
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    with pytest.raises(SceneError, match="a run is over"):
        snow_on(run, changes=("numerics.dx=0.2",))
