"""Runs in which snow comes and goes: stopped, killed and resumed with the same bits, read by all readers."""

import csv
import subprocess
import sys

import numpy as np
import pytest
from patience import PATIENCE, wait_until

from neve.export.registry import FORMATS
from neve.export.run import Choices, export_run
from neve.io.errors import RunError
from neve.io.frames import read_frame
from neve.io.npz import read_npz, write_npz
from neve.run import painter, run_scene
from neve.run.estimate import estimate
from neve.run.outputs.fragments import count_run
from neve.scene.reading.load import load
from neve.viewer.exports.replay import replay_of

SCENE = """
[numerics]
dx = 0.1
method = "METHOD"

[run]
duration = 0.5
fps = 12

[[emitters]]
shape = "box"
size = [0.2, 0.4, 0.4]
velocity = [4.0, 0, 0]
center = [0, 0, 0.6]
start = 0.1

[[emitters]]
shape = "sphere"
radius = 0.2
velocity = [0, 0, -2.0]
center = [0.6, 0, 1.2]
mass_rate = 20.0
spread = 10.0
end = 0.35

[[sinks]]
shape = "box"
size = [0.5, 4, 4]
center = [1.2, 0, 0]

[[colliders]]
shape = "plane"

[[outputs]]
kind = "checkpoint"
every_frames = 1
"""
LAST = 6


@pytest.fixture(autouse=True)
def small_picture(monkeypatch):
    """Draw pictures of a few pixels."""
    monkeypatch.setattr(painter, "SIZE", (64, 36))


@pytest.fixture(scope="module", params=["mpm", "particles"])
def path(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("open") / "open.toml"
    path.write_text(SCENE.replace("METHOD", request.param))
    return path


@pytest.fixture(scope="module")
def whole(path, tmp_path_factory):
    """A run in one go."""
    before, painter.SIZE = painter.SIZE, (64, 36)
    out = tmp_path_factory.mktemp("whole") / "run"
    run_scene(load(path), out, quiet=True, threads=1)
    painter.SIZE = before
    return out


def frames(out):
    return {file.name: file.read_bytes() for file in sorted((out / "frames").iterdir())}


def log(out):
    with open(out / "log.csv", newline="") as file:
        return [
            {k: v for k, v in row.items() if not k.startswith("seconds_")} for row in csv.DictReader(file)
        ]


def test_the_log_keeps_books(whole):
    """Mass is what came less what went; both happen in this run, and the start is empty."""
    rows = log(whole)
    assert rows[0]["particles"] == "0"
    assert float(rows[-1]["removed_mass"]) > 0
    for row in rows:
        balance = float(row["emitted_mass"]) - float(row["removed_mass"])
        assert float(row["mass"]) == pytest.approx(balance, rel=1e-12)


@pytest.mark.parametrize("stop", [1, 4])
def test_resume_is_exact(path, whole, tmp_path, stop):
    """Stopped before snow comes or while it goes, and resumed on other threads: the same frames and log."""
    run_scene(load(path), tmp_path / "run", frames=stop, quiet=True, threads=2)
    run_scene(load(path), tmp_path / "run", resume=True, quiet=True, threads=3)
    assert frames(tmp_path / "run") == frames(whole)
    assert log(tmp_path / "run") == log(whole)


def test_killed_in_the_middle(path, whole, tmp_path):
    """A process that is killed between two frames leaves a run that goes on to the same bits."""
    out = tmp_path / "run"
    process = subprocess.Popen(
        [sys.executable, "-m", "neve", "run", str(path), "--out", str(out), "--quiet"],
        stderr=subprocess.PIPE,
    )
    wait_until(lambda: (out / "frames/000002.npz").exists(), process)
    process.kill()
    process.communicate(timeout=PATIENCE)
    run_scene(load(path), out, resume=True, quiet=True)
    assert frames(out) == frames(whole)
    assert log(out) == log(whole)


@pytest.mark.parametrize("key", ["flow", "flow_books", "births", "born"])
def test_a_checkpoint_of_another_flow_is_refused(path, tmp_path, key):
    """What belongs to other emitters, or is not there, is one sentence."""
    run_scene(load(path), tmp_path / "run", frames=2, quiet=True)
    file = tmp_path / "run/checkpoint"
    arrays = read_npz(file)
    wrong = {"flow": np.zeros((3, 1)), "flow_books": np.zeros(2), "births": np.array([[0, 7]]), "born": 3}
    arrays[f"state.{key}"] = np.asarray(wrong[key])
    with open(file, "wb") as opened:
        write_npz(opened, arrays)
    with pytest.raises(RunError, match="does not fit its scene"):
        run_scene(load(path), tmp_path / "run", resume=True, quiet=True)


def test_frames_say_whose_snow_it_is(whole):
    """Each frame has source, mass and volume of its particles, in the order of their numbers."""
    frame = read_frame(whole / "frames", LAST)
    assert {*frame.more} == {"source", "m", "V0"}
    assert {*frame.more["source"].tolist()} == {0, 1}
    assert np.all(np.diff(frame.id.astype(np.int64)) > 0)
    assert frame.id.max() >= len(frame.id)
    assert len(read_frame(whole / "frames", 0).x) == 0


def test_every_format_takes_frames_without_and_with_snow(whole, tmp_path):
    """Exports of a run that begins empty and whose particles change: each format writes every frame."""
    for name in FORMATS.names():
        try:
            _, count = export_run(whole, Choices(name), tmp_path / name)
        except RunError as error:
            assert "needs the package" in str(error)  # noqa: PT017 (it may be installed or not)
        else:
            assert count == LAST + 1


def test_fragments_are_counted_of_snow_that_is_gone(whole, tmp_path):
    """The table weighs each frame with the masses that it holds: all of them, as the log has it."""
    count_run(whole, out=tmp_path / "f.csv")
    with open(tmp_path / "f.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in log(whole)[1:]:
        mass = sum(float(r["mass"]) for r in rows if r["frame"] == row["frame"])
        assert mass == pytest.approx(float(row["mass"]), rel=1e-5)


def test_a_replay_hides_what_is_not_there(whole):
    """The page of a run whose particles come and go has a place for each that ever was."""
    assert b"replay" in replay_of(str(whole))


def test_the_film_is_drawn_with_and_without_snow(whole):
    """The run has a film and a picture."""
    assert (whole / "preview.mp4").stat().st_size > 0
    assert (whole / "preview.png").stat().st_size > 0


def test_an_estimate_counts_what_will_come(path, whole):
    """The most particles at any time, and the largest frame, within a quarter."""
    found = estimate(load(path), frames=3, seconds=3600.0)
    most = int(log(whole)[3]["particles"])
    assert found.particles.likely == pytest.approx(most, rel=0.25)
    size = (whole / "frames/000003.npz").stat().st_size
    assert found.frame_bytes == pytest.approx(size, rel=0.25)
