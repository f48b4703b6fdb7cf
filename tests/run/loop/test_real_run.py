"""The run loop with the real simulation and the real film: a small snowball that falls on the ground."""

import contextlib
import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE, wait_until
from PIL import Image

import neve
from neve.io.errors import RunError
from neve.io.npz import read_npz, write_npz
from neve.run import painter, run_scene

SNOWBALL = """
[numerics]
dx = 0.1

[run]
duration = 0.25
fps = 20

[[sources]]
shape = "sphere"
center = [0.0, 0.0, 0.25]
radius = 0.2
velocity = [0.0, 0.0, -3.0]

[[colliders]]
shape = "plane"
"""


@pytest.fixture
def snowball(tmp_path):
    path = tmp_path / "snowball.toml"
    path.write_text(SNOWBALL)
    return path


@pytest.fixture
def small_picture(monkeypatch):
    """Draw pictures of a few pixels where they are not what is tested."""
    monkeypatch.setattr(painter, "SIZE", (64, 36))


def frames(out):
    return {path.name: path.read_bytes() for path in sorted((out / "frames").iterdir())}


@pytest.mark.parametrize(
    ("precision", "volume"), [("float32", "grid"), ("float32", "sampled"), ("float64", "grid")]
)
def test_resume_is_exact(small_picture, snowball, tmp_path, precision, volume):
    """A run stopped twice and resumed has the bytes of the straight run."""
    words = ["run.film=false", f"numerics.precision={precision}", f"numerics.initial_volume={volume}"]
    scene = neve.load(snowball, words)
    straight, parted = tmp_path / "straight", tmp_path / "parted"
    neve.Simulation(scene, threads=1).run(straight, quiet=True)
    neve.Simulation(scene, threads=1).run(parted, frames=1, quiet=True)
    neve.Simulation(scene, threads=1).run(parted, frames=3, resume=True, quiet=True)
    neve.Simulation(scene, threads=1).run(parted, resume=True, quiet=True)
    assert len(frames(straight)) == 6
    assert frames(parted) == frames(straight)


def test_scene_of_a_run_gives_the_same_run(small_picture, snowball, tmp_path):
    """`scene.toml` is complete: running it again, on other threads, gives the same bytes."""
    first, again = tmp_path / "first", tmp_path / "again"
    scene = neve.load(snowball, ["run.film=false", "numerics.seed=5"])
    neve.Simulation(scene, threads=1).run(first, quiet=True)
    neve.Simulation(neve.load(first / "scene.toml"), threads=2).run(again, quiet=True)
    assert frames(again) == frames(first)


def test_folder_of_a_real_run(snowball, tmp_path):
    """Frames, log, film and picture tell one story: the ball falls, and its impact costs energy."""
    out = tmp_path / "ball"
    sim = neve.Simulation(neve.load(snowball), threads=1).run(out, quiet=True)
    with open(out / "log.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["frame"]) for row in rows] == list(range(6))
    assert float(rows[-1]["time"]) == sim.time == pytest.approx(0.25)
    assert int(rows[-1]["steps"]) == sim.steps
    energy = [sum(float(row[name]) for name in ("kinetic", "elastic", "potential")) for row in rows]
    assert energy[-1] < 0.9 * energy[0]
    assert {row["bound"] for row in rows[1:]} <= {"wave", "speed", "fixed", "dt_max"}
    assert all(float(row["seconds_p2g"]) > 0 for row in rows[1:])
    assert all(float(row["seconds_film"]) > 0 for row in rows)
    with np.load(out / "frames/000005.npz") as last:
        assert np.array_equal(last["x"], sim.state.x[np.argsort(sim.state.id)])
    with Image.open(out / "preview.png") as picture:
        assert picture.size == (1280, 720)
    assert b"ftyp" in (out / "preview.mp4").read_bytes()[:16]
    assert sorted(path.name for path in out.iterdir()) == sorted(
        [
            "run.json",
            "scene.toml",
            "log.csv",
            "solids.csv",
            "frames",
            "checkpoint",
            "preview.png",
            "preview.mp4",
        ]
    )


def family(pid):
    """The process and those that it has started (Linux)."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    return [pid, *(child for child, parent in parents.items() if parent == pid)]


@pytest.mark.parametrize(
    ("number", "expected"), [pytest.param(signal.SIGINT, 130, id="ctrl_c"), (signal.SIGTERM, 143)]
)
def test_a_signal_to_all_processes(snowball, tmp_path, number, expected):
    """A terminal, systemd or a batch system signals the film's encoder too: it ends with the run, no sooner.

    The exit code is 128 + the signal, and --resume goes on.
    """
    straight, out = tmp_path / "straight", tmp_path / "ball"
    command = [sys.executable, "-m", "neve.cli", "run", str(snowball), "--out", str(out)]
    command += ["--threads", "1"]
    process = subprocess.Popen(
        [*command, "--set", "run.duration=30"],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    wait_until((out / "frames/000002.npz").exists, process)
    for member in reversed(family(process.pid)):  # the encoder first
        os.kill(member, number)
    told = process.communicate(timeout=PATIENCE)[1]
    assert (process.returncode, "Traceback" in told) == (expected, False), told
    done = len(frames(out)) - 1
    neve.Simulation(neve.load(out), threads=1).run(out, frames=done + 1, resume=True, quiet=True)
    scene = neve.load(snowball, ["run.film=false"])
    neve.Simulation(scene, threads=1).run(straight, frames=done + 1, quiet=True)
    assert frames(out) == frames(straight)
    assert b"ftyp" in (out / "preview.mp4").read_bytes()[:16]


def test_checkpoint_that_lacks_an_array(small_picture, snowball, tmp_path):
    """Whatever part of the state is gone, the resume is refused in one sentence that names it."""
    out = tmp_path / "ball"
    scene = neve.load(snowball, ["run.film=false"])
    neve.Simulation(scene, threads=1).run(out, frames=1, quiet=True)
    whole = read_npz(out / "checkpoint")
    names = [name for name in whole if name.startswith("state.")]
    assert {"state.exchanged", "state.time", "state.strength", "state.m", "state.modes"} <= set(names)
    for name in names:
        with open(out / "checkpoint", "wb") as file:
            write_npz(file, {key: value for key, value in whole.items() if key != name})
        with pytest.raises(RunError, match=rf"lacks parts of its state \({name.removeprefix('state.')}\)"):
            run_scene(scene, out, threads=1, resume=True, quiet=True)
