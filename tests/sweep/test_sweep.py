"""`neve sweep` on a cluster of two processes: its table, its bits, and what it makes of interruptions."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from neve.io.checkpoint import read_checkpoint
from neve.io.log import read_log
from neve.run import run_scene
from neve.scene.reading.load import load
from neve.sweep.plot import plot
from neve.sweep.table import read

pytest.importorskip("distributed")
psutil = pytest.importorskip("psutil")

SCENE = """
about = "A ball falls."
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
film = false
"""
OWN = """
def drop(run):
    rows = [line.split(",") for line in (run / "log.csv").read_text().splitlines()]
    return {"rows": len(rows) - 1, "name_length": len(run.name)}
def broken(run):
    raise ValueError("no")
def gate(run):
    # the first run ends at once, the others when there is a file that says so
    import pathlib, time
    while run.name != "0001" and not pathlib.Path("open").exists():
        time.sleep(0.02)
    return {}
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a folder with a scene, which is the current one."""
    (tmp_path / "ball.toml").write_text(SCENE)
    (tmp_path / "own.py").write_text(OWN)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def start(*words, **variables):
    """Start `neve sweep` in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "neve", "sweep", "ball.toml", *words, "--workers", "2"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ | variables,
    )  # fmt: skip


def neve_sweep(*words, code=0):
    """Run `neve sweep` and return what it said on standard error."""
    process = start(*words)
    _, said = process.communicate(timeout=300)
    assert process.returncode == code, said
    return said


def table(folder="sweeps/ball"):
    """Return the rows of the table."""
    if not os.path.exists(f"{folder}/sweep.csv"):
        return []
    with open(f"{folder}/sweep.csv", newline="") as file:
        return list(csv.DictReader(file))


def is_under_way(folder, frames):
    """Tell whether a run has so many frames."""
    return sum(1 for _ in folder.glob("frames/frame_*")) >= frames or (
        (folder / "log.csv").is_file() and (folder / "log.csv").read_text().count("\n") > frames
    )


def require_same_bits(run, other):
    """Compare all arrays of two runs' checkpoints."""
    here, there = (read_checkpoint(folder / "checkpoint").arrays for folder in (run, other))
    assert {*here} == {*there}
    for name in here:
        np.testing.assert_array_equal(here[name], there[name], err_msg=name)


def workers_of(process):
    """Return the processes of the cluster."""
    children = psutil.Process(process.pid).children()
    return [child for child in children if "spawn_main" in " ".join(child.cmdline())]


def wait_for(condition, process, seconds=120.0):
    """Wait until something is so while a process runs."""
    end = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end
        time.sleep(0.05)


def test_table_failures_bits_and_more_values(place):
    """Each run has a row with inputs and outputs, and the bits of that run alone; a refused one its sentence.

    The same command with more values runs these alone.
    """
    words = (
        "--output",
        "peak=kinetic@max",
        "--output",
        "start=potential@first",
        "--output",
        "late=time@0.04",
    )
    words += ("--output", "push=force_z[colliders.0]@min", "--output", "fragments.largest")
    words += ("--function", "own.py:drop")
    said = neve_sweep("--vary", "snow.xi=5,400", "--vary", "snow.E0=1e5,2e5", *words, code=1)
    assert said.count("snow.xi = 400 is not allowed") == 2
    rows = table()
    assert [(row["snow.xi"], row["snow.E0"], row["status"]) for row in rows] == [
        ("5", "100000.0", "done"),
        ("5", "200000.0", "done"),
        ("400", "100000.0", "failed"),
        ("400", "200000.0", "failed"),
    ]
    scene = load("ball.toml", ["snow.xi=5", "snow.E0=2e5"])
    run_scene(scene, "alone", threads=1, quiet=True)
    require_same_bits(place / "alone", place / "sweeps/ball/0002")
    log = read_log(place / "alone/log.csv", "mpm")
    row = rows[1]
    assert float(row["peak"]) == max(float(line["kinetic"]) for line in log)
    assert float(row["late"]) == min((float(line["time"]) for line in log), key=lambda time: abs(time - 0.04))
    assert float(row["push"]) < 0, "the snow presses on the ground"
    assert (row["fragments.largest"], row["rows"], row["name_length"]) == ("1.0", f"{len(log)}.0", "4.0")

    parquet = pytest.importorskip("pyarrow.parquet")
    held = parquet.read_table(place / "sweeps/ball/sweep.parquet").to_pylist()
    assert [line["peak"] for line in held] == [float(line["peak"]) if line["peak"] else None for line in rows]
    assert held[1]["snow.E0"] == 2e5

    before = (place / "sweeps/ball/0001/log.csv").stat().st_mtime_ns
    neve_sweep("--vary", "snow.xi=4,5", "--vary", "snow.E0=1e5", "--output", "peak=kinetic@max")
    assert [(row["run"], row["snow.xi"]) for row in table()] == [("0005", "4"), ("0001", "5")]
    assert (place / "sweeps/ball/0001/log.csv").stat().st_mtime_ns == before, "a run that is done stays"
    assert plot(place / "sweeps/ball").stat().st_size > 5000
    assert read(place / "sweeps/ball")[0]["peak"]


def test_a_worker_that_is_killed(place):
    """Killed, what a process was at goes on in another with the same bits; killed again, it is a row."""
    words = ("--vary", "snow.xi=5,6", "--set", "run.duration=1.5", "--output", "peak=kinetic@max")
    process = start(*words)
    folder = place / "sweeps/ball/0001"
    wait_for(lambda: is_under_way(folder, 3), process)
    assert len(workers_of(process)) == 2
    for worker in workers_of(process):
        worker.kill()
    _, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    assert [row["status"] for row in table()] == ["done", "done"]
    run_scene(load("ball.toml", ["snow.xi=5", "run.duration=1.5"]), "alone", threads=1, quiet=True)
    require_same_bits(place / "alone", folder)

    process = start(*words, "--out", "second", DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES="0")
    wait_for(lambda: is_under_way(place / "second/0001", 3), process)
    for worker in workers_of(process):
        worker.kill()
    _, said = process.communicate(timeout=300)
    assert process.returncode == 1
    assert "was ended from outside" in said
    assert [row["status"] for row in table("second")].count("failed") >= 1


def test_an_interrupted_sweep_goes_on(place):
    """Ctrl-C ends with 130 and one sentence; the table holds what is done; the same command does the rest."""
    words = ("--vary", "run.duration=0.01..0.06:6", "--function", "own.py:gate")
    process = start(*words)
    wait_for(lambda: "done" in {row["status"] for row in table()}, process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "the same command goes on with the rest" in said.splitlines()[-1]
    assert "Traceback" not in said
    done = [row["run"] for row in table() if row["status"] == "done"]
    assert done == ["0001"]
    (place / "open").touch()
    stamps = {run: os.stat(f"sweeps/ball/{run}/log.csv").st_mtime_ns for run in done}
    neve_sweep(*words)
    assert [row["status"] for row in table()] == ["done"] * 6
    assert stamps == {run: os.stat(f"sweeps/ball/{run}/log.csv").st_mtime_ns for run in done}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "nothing varies"),
        (("--vary", "snow.xj=1,2"), "snow.xj is not a known key"),
        (("--vary", "snow.xi=1,2", "--output", "a=kineti"), "did you mean kinetic"),
        (("--vary", "snow.xi=1,2", "--output", "a=kinetic@mox"), "did you mean max"),
        (("--vary", "snow.xi=1,2", "--output", "a=force_z[colliders.7]"), "no solid colliders.7"),
        (("--vary", "snow.xi=1,2", "--output", "status=kinetic"), "another column of this name"),
        (("--vary", "snow.xi=1,2", "--function", "own.py:missing"), "no function missing"),
        (("--vary", "snow.xi=1,2", "--function", "none.py:f"), "cannot be read"),
        (("--vary", "snow.xi=1..2", "--design", "latin"), "needs --samples"),
        (("--vary", "snow.xi=1,2", "--samples", "3"), "of --design latin"),
        (("--vary", "snow.xi=1,2", "--out", "."), "is not empty and holds no sweep"),
    ],
)
def test_bad_input_is_one_sentence(place, words, said):
    """Exit code 2 and nothing written."""
    heard = neve_sweep(*words, code=2)
    assert said in heard
    assert len(heard.strip().splitlines()) == 1
    assert not os.path.exists("sweeps")


def test_a_failing_function_and_another_scene(place):
    """A function that fails is the sentence of its row; a folder keeps to the scene that its runs have."""
    heard = neve_sweep("--vary", "snow.xi=5", "--function", "own.py:broken", code=1)
    assert "broken failed on" in heard
    assert "ValueError: no" in heard
    (place / "ball.toml").write_text(SCENE.replace("radius = 0.2", "radius = 0.25"))
    assert "sources.0.radius is 0.2 there and 0.25 now" in neve_sweep("--vary", "snow.xi=5", code=2)
    (place / "sweeps/ball/sweep.json").write_text(json.dumps({"format": 1, "runs": {"snow.xi=5": "../x"}}))
    assert "sweep.json is damaged" in neve_sweep("--vary", "snow.xi=5", code=2)
