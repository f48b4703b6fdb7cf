"""Runs with compact frames: the snow moves as ever, all that reads frames agrees, and kinds may be mixed."""

import numpy as np
import pytest

from neve import Simulation
from neve.export.run import Choices, export_run
from neve.io.checkpoint import read_checkpoint
from neve.io.frames import FOR_LIFE, read_frame
from neve.io.npz import read_npz
from neve.io.run_folder import RunFolder
from neve.run import run_scene
from neve.run.outputs.context import FrameContext, RunContext
from neve.run.outputs.fragments import count_run
from neve.scene.reading.load import load
from neve.stage_timer import StageTimer
from neve.viewer.exports.replay import replay_page

SCENE = """
[run]
duration = 0.2
fps = 20
film = false
fragments = true
[numerics]
dx = 0.1
[[sources]]
shape = "sphere"
radius = 0.3
center = [0, 0, 0.35]
velocity = [0, 0, -4]
[[colliders]]
shape = "plane"
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(SCENE, encoding="utf-8")
    return lambda *changes: load(path, changes)


COMPACT = "run.frames='compact'"


def exported(run):
    """How many frames of a run an export has."""
    folder, _ = export_run(run, Choices("ply"))
    return len(list(folder.glob("*.ply")))


def test_the_snow_moves_as_ever(scene, tmp_path):
    """State, log and checkpoint are those of a run with plain frames; frames differ within their bounds."""
    run_scene(scene(), tmp_path / "plain", quiet=True)
    run_scene(scene(COMPACT), tmp_path / "compact", quiet=True)
    one, other = (read_checkpoint(tmp_path / kind / "checkpoint") for kind in ("plain", "compact"))
    for name, values in one.arrays.items():
        assert np.array_equal(values, other.arrays[name]), name
    for frame in range(5):
        plain, compact = (read_frame(tmp_path / kind / "frames", frame) for kind in ("plain", "compact"))
        assert np.abs(compact.x - plain.x).max() <= 0.4 / 131072 + 1e-7
        assert np.abs(compact.v - plain.v).max() <= 2**-11 * np.abs(plain.v).max()
        assert np.array_equal(compact.id, plain.id)


def test_all_that_reads_frames_agrees(scene, tmp_path):
    """Pieces counted during the run and afterwards, an export of the run and the page that plays it."""
    out = tmp_path / "run"
    run_scene(scene(COMPACT), out, quiet=True)
    during = (out / "fragments.csv").read_bytes()
    count_run(out)
    assert (out / "fragments.csv").read_bytes() == during
    assert exported(out) == 5
    assert len(replay_page(RunFolder(out))) > 1000


def test_kinds_may_be_mixed(scene, tmp_path):
    """A run that is resumed with the other kind has files of both, and the same snow."""
    straight, mixed = tmp_path / "straight", tmp_path / "mixed"
    run_scene(scene(COMPACT), straight, quiet=True)
    run_scene(scene(), mixed, frames=2, quiet=True)
    run_scene(scene(COMPACT), mixed, resume=True, quiet=True)
    compact = ["x_in_block" in read_npz(mixed / f"frames/{k:06d}.npz") for k in range(5)]
    assert compact == [False, False, False, True, True]
    for k in (3, 4):
        name = f"frames/{k:06d}.npz"
        assert (mixed / name).read_bytes() == (straight / name).read_bytes()
    assert exported(mixed) == 5


def test_what_particles_keep_for_life_is_exact(scene, tmp_path):
    """A field of `run.fields` is rounded, mass and volume never."""
    run_scene(scene(COMPACT, "run.fields=['m', 'V0', 'F_E']"), tmp_path / "run", frames=1, quiet=True)
    found = read_frame(tmp_path / "run/frames", 1)
    arrays = read_checkpoint(tmp_path / "run/checkpoint").arrays
    order = np.argsort(arrays["id"])
    for name in FOR_LIFE:
        assert np.array_equal(found.more[name], arrays[name][order])
    assert np.abs(found.more["F_E"] - arrays["F_E"][order]).max() <= 2**-11 * np.abs(arrays["F_E"]).max()


def test_numbers_that_are_not_finite_are_handed_on(scene, tmp_path):
    """An output finds in a frame that cannot be compact what the state holds."""
    sim = Simulation(scene(COMPACT))
    run = RunContext(RunFolder(tmp_path), sim.scene, "", "", [], None)
    assert not np.array_equal(FrameContext(sim, 0, 1, StageTimer(), run).content.x, sim.state.x)
    sim.state.v[3] = np.nan
    content = FrameContext(sim, 0, 1, StageTimer(), run).content
    order = np.argsort(sim.state.id)
    assert np.array_equal(content.x, sim.state.x[order])
    assert np.array_equal(content.v, sim.state.v[order], equal_nan=True)
