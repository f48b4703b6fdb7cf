"""Runs and pictures on a Dask cluster that is there already."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("distributed")

SCENE = """
[numerics]
dx = 0.1
[[sources]]
shape = "sphere"
center = [0.0, 0.0, 0.3]
radius = 0.2
[[colliders]]
shape = "plane"
[run]
duration = 0.1
film = false
"""


@pytest.fixture
def address():
    """Return the address of a cluster."""
    with subprocess.Popen(
        [sys.executable, str(Path(__file__).with_name("elsewhere.py"))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        yield process.stdout.readline().strip()
        process.stdin.close()
        process.wait(60)


def neve(folder, *words):
    """Run a command in a folder; return its exit code and what it said."""
    command = [sys.executable, "-m", "neve", *words]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
    return done.returncode, done.stdout + done.stderr


def require_same_files(here, there, pattern="*[0-9].*"):
    """Compare the files of both folders, one for each of four frames at least."""
    names = sorted(path.name for path in here.glob(pattern))
    assert len(names) >= 4
    assert names == sorted(path.name for path in there.glob(pattern))
    for name in names:
        assert (there / name).read_bytes() == (here / name).read_bytes()


def test_a_sweep_and_pictures_elsewhere(tmp_path, address):
    """The cluster makes runs, and exports and draws their frames, byte for byte as this machine does."""
    (tmp_path / "ball.toml").write_text(SCENE)
    code, said = neve(tmp_path, "sweep", "ball.toml", "--vary", "snow.xi=5,6", "--scheduler", address)
    assert (code, "2 runs" in said) == (0, True), said
    for kind in ("ply", "obj", "glb", "usd", "vdb", "vtk"):
        assert neve(tmp_path, "export", "sweeps/ball/0001", "--to", kind, "--out", f"{kind}_here")[0] == 0
        words = ("--to", kind, "--out", f"{kind}_there", "--scheduler", address)
        code, said = neve(tmp_path, "export", "sweeps/ball/0001", *words)
        assert (code, "4 new frames" in said) == (0, True), said
        require_same_files(tmp_path / f"{kind}_here", tmp_path / f"{kind}_there")
        assert ": 0 new frames" in neve(tmp_path, "export", "sweeps/ball/0001", *words)[1]
    code, said = neve(tmp_path, "export", "sweeps/ball/0001", "--to", "abc", "--scheduler", address)
    assert (code, "one file of all frames" in said) == (2, True), said
    if not importlib.util.find_spec("mitsuba"):
        pytest.skip("pictures need Mitsuba 3")
    small = ("--size", "48x32", "--quality", "draft", "--spp", "1", "--quiet", "--set", "camera.follow=snow")
    run = "sweeps/ball/0001"
    assert neve(tmp_path, "render", run, *small, "--out", "here", "--jobs", "1")[0] == 0
    code, said = neve(tmp_path, "render", run, *small, "--out", "there", "--scheduler", address)
    assert (code, ": 4 new pictures" in said) == (0, True), said
    require_same_files(tmp_path / "here", tmp_path / "there", "*.png")
    code, said = neve(tmp_path, "render", run, *small, "--out", "there", "--scheduler", address)
    assert (code, ": 0 new pictures" in said) == (0, True), said


def test_no_cluster_is_one_sentence(tmp_path):
    """Nothing answers at the address."""
    (tmp_path / "ball.toml").write_text(SCENE)
    code, said = neve(
        tmp_path, "sweep", "ball.toml", "--vary", "snow.xi=5,6", "--scheduler", "tcp://127.0.0.1:1"
    )
    assert (code, len(said.strip().splitlines())) == (2, 1), said
    assert "nothing answers there" in said
