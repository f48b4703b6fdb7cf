"""The table of a sweep: inputs first, what earlier calls have left, and how runs are known again."""

import csv
import json
import os
import threading
import time
import types

import pytest
from sweep.test_kinds import SCENE

from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.scene.reading.load import load
from neve.sweep import run as running
from neve.sweep import spent
from neve.sweep.design import read_vary
from neve.sweep.inputs import distinct, inputs_of, name_of
from neve.sweep.measures import read_measure
from neve.sweep.plan import read_plan
from neve.sweep.plot import plot
from neve.sweep.run import Sweep, sweep
from neve.sweep.table import DONE, Row, read, write
from neve.system import cluster
from neve.system.cluster import ClusterError

PLAN = """
scene = "ball.toml"
design = "grid"
[vary]
"snow.xi" = [5, 10]
[[points]]
"snow.xi" = 7
"snow.nu" = 0.3
[outputs]
peak = "kinetic@max"
"""


@pytest.fixture
def ball(tmp_path):
    """Return the path of a small scene."""
    (tmp_path / "ball.toml").write_text(SCENE)
    return tmp_path / "ball.toml"


def test_inputs_of_single_points(ball, tmp_path):
    """All inputs stand first, with the scene's own value where a row gives none; they can be plotted."""
    (tmp_path / "plan.toml").write_text(PLAN)
    plan = read_plan(tmp_path / "plan.toml")
    scenes = [load(ball, [f"{key}={value}" for key, value in point.items()]) for point in plan.points]
    inputs = inputs_of(plan.points, scenes)
    own = load(ball, []).snow.nu
    assert [point["snow.nu"] for point in inputs] == [own, own, 0.3]
    rows = [Row(f"{k}", point, DONE, "", 1.0, {"peak": 2.0 + k}) for k, point in enumerate(inputs)]
    write(tmp_path, rows)
    names = [*read(tmp_path)[0]]
    assert names == ["run", "snow.xi", "snow.nu", "status", "sentence", "seconds", "peak"]
    plot(tmp_path, x="snow.nu")


def test_blank_inputs(tmp_path):
    """A value that only a later row has stands before the outputs; plots leave out a row without it."""
    write(tmp_path, [Row("1", {"a": 1.0}, DONE, "", 1.0, {"y": 1.0})] + [
        Row(f"{k}", {"a": 2.0, "b": float(k)}, DONE, "", 1.0, {"y": 1.0 * k}) for k in (2, 3)
    ])  # fmt: skip
    assert [*read(tmp_path)[0]][:4] == ["run", "a", "b", "status"]
    plot(tmp_path, x="b", by="a")
    plot(tmp_path, x="a", by="b")


def test_the_same_run():
    """Another order of keys and 5 for 5.0 mean the same run; the order of keys inside each other counts."""
    assert name_of(["snow.xi=5", "snow.nu=0.3"]) == name_of(["snow.nu=0.30", "snow.xi=5.0"])
    assert name_of(["snow.xi=5", "snow.xi=6"]) == name_of(["snow.xi=6"])
    assert name_of(["a.v=[0, 1.0]"]) == name_of(["a.v=[0.0,1]"])
    assert name_of(["a=x"]) == name_of(['a="x"'])
    assert name_of(["a={ b = 1 }", "a.b=2"]) != name_of(["a.b=2", "a={ b = 1 }"])
    assert name_of(["a=true"]) != name_of(["a=1"])
    assert distinct([{"a": 5}, {"a": 5.0}, {"a": 6}]) == [{"a": 5}, {"a": 6}]


def refuse(*_):
    raise ClusterError("nothing answers there.")


def test_finished_rows_outlive_a_cluster_that_is_not_there(ball, tmp_path, monkeypatch):
    """Outputs and wall times of runs that are done stay in the table; runs not done to this end do not."""
    monkeypatch.setattr(running, "require_dask", lambda: None)
    monkeypatch.setattr(running, "cluster", refuse)
    out = tmp_path / "out"
    point = {"snow.xi": 5}
    plan = Sweep(str(ball), [point, {"snow.xi": 6}], measures=[read_measure("peak=kinetic@max")], frames=2)
    folder = out / "0001"
    folder.mkdir(parents=True)
    (folder / "run.json").write_text("{}")
    (out / "sweep.json").write_text(json.dumps({"format": 1, "runs": {"snow.xi=5": "0001"}}))
    (folder / spent.FILE).write_text(json.dumps({"seconds": 12.5, "frame": 2}))
    write(out, [Row("0001", point, DONE, "", 12.5, {"peak": 3.5})])
    with pytest.raises(ClusterError):
        sweep(plan, out)
    first, second = read(out)
    assert (first["run"], first["status"], first["seconds"], first["peak"]) == ("0001", "done", "12.5", "3.5")
    assert (second["run"], second["status"], second["peak"]) == ("0002", "waiting", "")
    other = [{"snow.xi": 5.0}]
    with pytest.raises(ClusterError):
        sweep(Sweep(str(ball), other, measures=plan.measures, frames=3), out)
    (row,) = read(out)
    assert (row["run"], row["status"]) == ("0001", "waiting"), "it is known again, but has another end"


def test_wall_times_add_up(tmp_path):
    """A run that goes on has the time of both calls; one that is replaced that of the last."""
    run = RunFolder(tmp_path)
    run.open("0")
    for anew, error in ((False, ValueError), (False, None), (True, None)):
        before = spent.read(tmp_path)
        try:
            with spent.counted(tmp_path, 4, anew):
                if error:
                    raise error
        except ValueError:
            pass
        now = spent.read(tmp_path)
        assert now.frame == (spent.UNFINISHED if error else 4)
        assert before is None or (now.seconds > before.seconds) or anew
    assert spent.FILE in json.loads((tmp_path / "run.json").read_text())["files"]


def test_processors_of_an_allocation(ball, tmp_path, monkeypatch):
    """Processes and threads share the processors that this process may use, not those of the machine."""
    asked = {}

    def note(folder, rows, tasks, workers, scheduler, progress):
        asked.update(workers=workers, threads={task.threads for task in tasks.values()})

    monkeypatch.setattr(running, "require_dask", lambda: None)
    monkeypatch.setattr(running, "_carry_out", note)
    monkeypatch.setattr(os, "cpu_count", lambda: 64)
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1, 2, 3, 4, 5}, raising=False)
    points = [{"snow.xi": value} for value in read_vary("snow.xi=5,6,7").listed()]
    sweep(Sweep(str(ball), points), tmp_path / "out")
    assert asked == {"workers": 3, "threads": {2}}
    with open(tmp_path / "out/sweep.csv", newline="") as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["waiting"] * 3


def test_no_kind_has_it(ball, tmp_path, monkeypatch):
    """A column that some methods have is taken from these; one that none has is refused."""
    monkeypatch.setattr(running, "require_dask", lambda: None)
    monkeypatch.setattr(running, "_carry_out", lambda *_: None)
    points = [{"numerics.method": word} for word in ("mpm", "particles")]
    sweep(Sweep(str(ball), points, measures=[read_measure("blocks")]), tmp_path / "out")
    with pytest.raises(RunError, match="no column blockz"):
        sweep(Sweep(str(ball), points, measures=[read_measure("blockz")]), tmp_path / "other")


def test_one_run_at_a_time_in_a_worker(monkeypatch):
    """A worker with several threads does one run at a time, on as many threads as it has."""
    distributed = pytest.importorskip("distributed")
    busy, most = [], []

    def call(item):
        busy.append(item)
        most.append(len(busy))
        time.sleep(0.02)
        busy.remove(item)

    threads = [threading.Thread(target=cluster._alone, args=(call, k)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1, 1, 1]
    assert cluster.threads_here() is None
    worker = types.SimpleNamespace(state=types.SimpleNamespace(nthreads=6))
    monkeypatch.setattr(distributed, "get_worker", lambda: worker)
    assert cluster.threads_here() == 6
