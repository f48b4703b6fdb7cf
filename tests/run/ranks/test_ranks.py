"""One scene over ranks has the bits of one, on any number of them, also where it is resumed or cut short."""

import contextlib
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from run.ranks.launching import (
    BODIES,
    asks_before_it_kills,
    command,
    environment,
    launched,
    require_mpi,
    require_same,
    run,
    write_scene,
)
from run.ranks.shared import FRAMES, SECONDS, TAKEN

import neve
from neve.io.checkpoint import read_checkpoint
from neve.ranks import launch
from neve.ranks.ownership import UNEVEN
from neve.ranks.transport import MOST

KINDS = {
    "affine": (2, {}),
    "forces apart": (3, {"transfer": "flip"}),
    "surfaces with play": (2, {"transfer": "asflip", "mode": "slip"}),
    "bodies": (2, {"more": BODIES}),
    "bodies on surfaces with play": (3, {"more": BODIES, "mode": "slip", "transfer": "flip"}),
    "further modes, in double": (4, {"transfer": "polypic", "precision": "float64"}),
}


@pytest.fixture(autouse=True)
def _mpi():
    require_mpi()


@pytest.mark.parametrize("kind", KINDS)
def test_bits_of_one_rank(tmp_path, kind):
    """Frames, checkpoint, log and forces on solids, to the bit; lumps cross from rank to rank meanwhile."""
    ranks, options = KINDS[kind]
    scene = write_scene(tmp_path, **options)
    run(1, scene, "--out", tmp_path / "one", "--quiet")
    run(ranks, scene, "--out", tmp_path / "several", "--quiet")
    require_same(tmp_path / "one", tmp_path / "several")


def test_resume_on_other_ranks(tmp_path):
    """A run over two ranks goes on over three, then on one: as in one go."""
    scene = write_scene(tmp_path)
    run(1, scene, "--out", tmp_path / "one", "--quiet")
    parts = tmp_path / "parts"
    run(2, scene, "--out", parts, "--quiet", "--frames", "1")
    run(3, parts, "--resume", "--quiet", "--frames", "3")
    run(1, parts, "--resume", "--quiet")
    require_same(tmp_path / "one", parts)


@pytest.mark.parametrize(
    ("ranks", "threads", "uneven", "most"),
    [(3, 1, 0.0, MOST), (2, 2, UNEVEN, 1000), (8, 1, UNEVEN, MOST)],
    ids=["anew", "threads", "eight"],
)
def test_ranks_take_part(tmp_path, ranks, threads, uneven, most):
    """Each rank owns particles and gives to others, particles move from rank to rank, and the bits are one's.

    uneven: the bound from which on shares are chosen anew; with 0 it is done at every sort
    most: bytes of a message; what is longer goes in several
    """
    scene = write_scene(tmp_path, more=BODIES)
    program = Path(__file__).with_name("shared.py")
    words = (program, scene, tmp_path / "several.npz", threads, uneven, most)
    subprocess.run(launched(ranks, *words), env=environment(), check=True, timeout=400)
    sim = neve.Simulation(neve.load(scene), threads=1)
    for _ in range(FRAMES):
        sim.advance(SECONDS)
    with np.load(tmp_path / "several.npz") as several:
        found = dict(several)
    particles, halo, migrated, rebalanced = (found.pop(name) for name in TAKEN)
    assert len(particles) == ranks
    assert particles.min() > 0
    assert particles.sum() == sim.count
    assert halo.min() > 0
    assert migrated.sum() > 0
    assert rebalanced.min() == rebalanced.max()
    assert rebalanced.max() > 0 or uneven
    expected = sim.arrays()
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        np.testing.assert_array_equal(found[name], value, err_msg=name)


def test_a_rank_is_killed(tmp_path):
    """One sentence, an exit code that says so, and a run that goes on from its checkpoint."""
    scene = write_scene(tmp_path)
    long = scene.read_text().replace("duration = 0.04", "duration = 20.0")
    scene.write_text(long + '\n[[outputs]]\nkind = "checkpoint"\nevery_frames = 1\n')
    out = tmp_path / "killed"
    started = subprocess.Popen(
        command(2, "run", scene, "--out", out, "--quiet", "--threads", "1"),
        env=environment(), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        deadline = time.monotonic() + 300
        while not (out / "checkpoint").exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        assert (out / "checkpoint").exists()
        os.kill(follower_of(started.pid), signal.SIGKILL)
        _, said = started.communicate(timeout=300)
    finally:
        started.kill()
    ours = [line for line in said.splitlines() if line.startswith("neve:")]
    assert not asks_before_it_kills() or ours == [
        "neve: the run over 2 ranks was ended (a rank is gone, or it was told to stop); continue with: "
        f"neve run {out} --resume"
    ]
    assert started.returncode != 0
    done = read_checkpoint(out / "checkpoint").frame
    run(2, out, "--resume", "--quiet", "--frames", str(done + 1))
    run(1, scene, "--out", tmp_path / "one", "--quiet", "--frames", str(done + 1))
    require_same(tmp_path / "one", out)


def follower_of(launcher):
    """The process of rank 1, somewhere below the launcher."""
    for folder in Path("/proc").iterdir():
        with contextlib.suppress(OSError):
            if not folder.name.isdigit():
                continue
            pairs = (pair.partition("=") for pair in (folder / "environ").read_text().split("\0"))
            variables = {name: value for name, _, value in pairs}
            if launch.rank(variables) == 1 and launcher in ancestors_of(int(folder.name)):
                return int(folder.name)
    raise AssertionError("no rank 1")


def ancestors_of(process):
    """The processes above it, the nearest first."""
    found = []
    while process > 1:
        process = int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
        found.append(process)
    return found


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ("numerics.sleep=true", "numerics.sleep = true: a run over 2 ranks cannot do that; set it to false"),
        ("numerics.dx=-1", "numerics.dx = -1"),
    ],
)
def test_one_sentence(tmp_path, change, sentence):
    """What is refused is said once, not by each rank, and no folder is begun."""
    said = run(2, write_scene(tmp_path), "--out", tmp_path / "out", "--set", change, "--quiet", code=2)
    ours = [line for line in said.splitlines() if line.startswith("neve:")]
    assert len(ours) == 1
    assert sentence in ours[0]
    assert not (tmp_path / "out" / "frames").exists()
