"""`fragments.csv`: what a run writes, what is computed afterwards, and that stopping changes nothing."""

import csv
import json

import numpy as np
import pytest

from neve.cli import main
from neve.fragments import COLUMNS, MOST, Limits, find, rows
from neve.io.errors import RunError
from neve.run import run
from neve.run.outputs.fragments import count_run
from neve.scene.reading.load import load

COARSE = ["numerics.dx=0.5"]  # the stand-in's 50 particles in a cube of 1 m then hang together, most of them


@pytest.fixture
def counted(scene_file):
    """The small scene of eight frames with its fragments counted."""
    return load(scene_file, [*COARSE, "run.fragments=true"])


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_table_of_a_run(fake, counted, tmp_path):
    """A frame has its fragments by rank and a row of powder; they add up to mass and momentum of the log."""
    out = tmp_path / "ball"
    run(fake.Simulation(counted), out, quiet=True)
    lines, log = table(out / "fragments.csv"), table(out / "log.csv")
    assert tuple(lines[0]) == COLUMNS
    for row in log:
        mine = [line for line in lines if line["frame"] == row["frame"]]
        kinds = [line["kind"] for line in mine]
        assert kinds == ["fragment"] * (len(kinds) - 1) + ["powder"]
        assert [line["rank"] for line in mine[:-1]] == [str(1 + k) for k in range(len(kinds) - 1)]
        assert sum(int(line["particles"]) for line in mine) == int(row["particles"])
        assert sum(float(line["mass"]) for line in mine) == pytest.approx(float(row["mass"]), rel=1e-12)
        flow = sum(float(line["mass"]) * float(line["velocity_z"] or 0) for line in mine)
        assert flow == pytest.approx(float(row["momentum_z"]), rel=1e-6, abs=1e-6)
        assert mine[0]["time"] == row["time"]
    assert any(line["kind"] == "fragment" for line in lines)


def test_afterwards_is_the_same(fake, counted, scene_file, tmp_path):
    """A run with the switch off, counted from its frames, has the same file to the byte."""
    run(fake.Simulation(counted), tmp_path / "on", quiet=True)
    run(fake.Simulation(load(scene_file, COARSE)), tmp_path / "off", quiet=True)
    assert not (tmp_path / "off/fragments.csv").exists()
    found = count_run(tmp_path / "off")
    assert (tmp_path / "off/fragments.csv").read_bytes() == (tmp_path / "on/fragments.csv").read_bytes()
    assert found.count == sum(row["frame"] == "8" for row in table(tmp_path / "off/fragments.csv")) - 1


@pytest.mark.parametrize("before", ["true", "false"])
def test_resumed_table_is_the_same(fake, counted, scene_file, tmp_path, before):
    """A run stopped and resumed has the same rows, also those of frames from before the switch was set."""
    straight, parted = tmp_path / "straight", tmp_path / "parted"
    run(fake.Simulation(counted), straight, quiet=True)
    early = load(scene_file, [*COARSE, f"run.fragments={before}"])
    run(fake.Simulation(early), parted, frames=3, quiet=True)
    run(fake.Simulation(counted), parted, frames=3, resume=True, quiet=True)
    run(fake.Simulation(counted), parted, resume=True, quiet=True)
    assert (parted / "fragments.csv").read_bytes() == (straight / "fragments.csv").read_bytes()
    run(fake.Simulation(counted), parted, force=True, frames=1, quiet=True)
    assert {row["frame"] for row in table(parted / "fragments.csv")} == {"0", "1"}


def test_command(fake, scene_file, tmp_path, capsys):
    """`neve fragments` tells the last frame, as a sentence and as JSON; its limits count."""
    out = tmp_path / "ball"
    run(fake.Simulation(load(scene_file, COARSE)), out, quiet=True)

    def call(*words):
        with pytest.raises(SystemExit) as stop:
            main(["fragments", str(out), *words])
        told = capsys.readouterr()
        return stop.value.code, told.out, told.err

    code, told, _ = call()
    assert code == 0
    assert told.startswith("the last frame has ")
    assert json.loads(call("--json", "--torn", "0.001")[1])["powder"] == pytest.approx(1.0)
    every = json.loads(call("--json", "--least", "1", "--torn", "1e9", "--link", "1e-6")[1])
    assert every["fragments"] == 50
    assert call("--link", "0")[0::2] == (2, "neve: --link: 0.0 is not a finite number greater than 0\n")


def test_what_cannot_be_counted(fake, counted, tmp_path):
    """No run, no frames, and limits of one's own for a table that the run keeps: one sentence each."""
    with pytest.raises(RunError, match="holds no Neve run"):
        count_run(tmp_path)
    out = tmp_path / "ball"
    run(fake.Simulation(counted), out, quiet=True)
    with pytest.raises(RunError, match="choose another file with --out"):
        count_run(out, Limits(least=3))
    assert count_run(out, Limits(least=1, link=1e-6), tmp_path / "other.csv").count == 50
    for path in (out / "frames").iterdir():
        path.unlink()
    with pytest.raises(RunError, match="holds no frames"):
        count_run(out)


def test_more_fragments_than_rows():
    """Of MOST + 3 grains far apart the lightest three share a row; the rows add up to the whole."""
    n = MOST + 3
    x = np.arange(3.0 * n).reshape(n, 3)
    m = np.arange(1.0, n + 1)
    f = find(x, x, np.ones(n), m, np.ones(n), spacing=0.1, limits=Limits(least=1))
    lines = list(rows(f, 7, 0.5))
    assert [line["kind"] for line in lines[-2:]] == ["rest", "powder"]
    assert (lines[-2]["mass"], lines[-2]["particles"], lines[-2]["rank"]) == (6.0, 3, None)
    assert lines[-2]["x"] == pytest.approx(m[:3] @ x[:3, 0] / 6)
    assert len(lines) == MOST + 2
    assert sum(line["mass"] for line in lines) == m.sum()
