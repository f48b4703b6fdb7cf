"""What a run over ranks says when it cannot begin, and how it ends when one of them fails."""

import subprocess
import sys
import types
from pathlib import Path

import pytest
from run.ranks.launching import SCENE, environment, launched, require_mpi

import neve
from neve.ranks import launch, simulation, world
from neve.run import run_scene
from neve.scene.reading.load import load

FAILING = Path(__file__).with_name("failing.py")
TINY = SCENE.replace("dx = 0.08", "dx = 0.15").format(
    transfer="apic", precision="float32", mode="separate", more=""
)


@pytest.fixture
def scene(tmp_path):
    """Return the path of a small scene."""
    (tmp_path / "tiny.toml").write_text(TINY)
    return tmp_path / "tiny.toml"


@pytest.mark.parametrize(
    ("fails", "said"),
    [
        ("fault", ("ValueError: injected", "neve: rank 1 of 2 cannot go on; ")),
        ("lost", ("m from the origin",)),
    ],
)
def test_one_rank_fails(tmp_path, scene, fails, said):
    """A fault, or a particle that is lost, on one rank ends all of them with one sentence."""
    require_mpi()
    out = tmp_path / "out"
    words = ("run", scene, "--out", out, "--quiet", "--threads", "1")
    done = subprocess.run(
        launched(2, FAILING, *words),
        env=environment() | {"NEVE_FAILS": fails}, capture_output=True, text=True, timeout=400,
    )  # fmt: skip
    assert done.returncode != 0
    for words in said:
        assert words in done.stderr
    if fails == "fault":
        assert f"continue with: neve run {out} --resume" in done.stderr
    ours = [line for line in done.stderr.splitlines() if line.startswith("neve:")]
    assert len([line for line in ours if not ("was ended" in line or "warning" in line)]) == 1, ours


@pytest.mark.parametrize("rank", [0, 1])
def test_a_launch_by_another_mpi(monkeypatch, rank):
    """What mpirun has told and what MPI knows are compared, on every rank."""
    monkeypatch.setenv("PMI_SIZE", "2")
    monkeypatch.setenv("PMI_RANK", str(rank))
    monkeypatch.delenv("OMPI_COMM_WORLD_SIZE", raising=False)
    monkeypatch.delenv("OMPI_COMM_WORLD_RANK", raising=False)
    with pytest.raises(world.RanksError, match=f"rank {rank} of 2, and mpi4py finds itself rank 0 of 1"):
        world.checked(types.SimpleNamespace(rank=0, size=1))
    monkeypatch.setitem(sys.modules, "mpi4py", types.SimpleNamespace(MPI=_alone()))
    world.world.cache_clear()
    monkeypatch.setattr(simulation, "end_when_asked", lambda: None)
    if rank:
        assert launch.follow() == 2
    else:
        with pytest.raises(world.RanksError), launch.leading():
            pass


def _alone():
    return types.SimpleNamespace(COMM_WORLD=types.SimpleNamespace(rank=0, size=1))


def test_a_run_inside_a_program_that_mpirun_started(monkeypatch, tmp_path, scene):
    """Only `neve run` is shared out: a worker of a cluster, or a program of the user's, runs alone."""
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    monkeypatch.setenv("OMPI_COMM_WORLD_RANK", "0")
    kinds = []
    monkeypatch.setattr(world, "world", lambda: kinds.append("ranks"))
    monkeypatch.setattr(simulation, "world", lambda: kinds.append("ranks"))
    sim = run_scene(load(scene, ["run.fps=1000", "run.duration=0.001"]), tmp_path / "out", 1, 1, quiet=True)
    assert type(sim) is neve.Simulation
    assert not kinds


def test_threads_of_an_allocation(monkeypatch):
    """Ranks of a machine share the cores that they may use, not all that it has."""
    monkeypatch.setenv("OMPI_COMM_WORLD_LOCAL_SIZE", "2")
    monkeypatch.setattr("os.cpu_count", lambda: 64)
    monkeypatch.setattr("os.sched_getaffinity", lambda process: set(range(6)), raising=False)
    assert simulation.usual_threads() == 3


def test_a_device_that_is_chosen(scene):
    """Ranks compute on processors, also where a GPU would be chosen."""
    assert simulation.on_processors(load(scene, ['numerics.device="auto"'])).numerics.device == "cpu"
    here = load(scene, [])
    assert simulation.on_processors(here) == here


def test_the_sentence_of_a_follower(monkeypatch):
    """It names the folder, which the leader has told; without one it names none."""
    monkeypatch.setattr(world, "_place", "")
    assert "neve run" not in world.resumable()
    world.resumable("runs/x")
    assert (world.place(), world.resumable()) == ("runs/x", "continue with: neve run runs/x --resume")
