"""The script for the day a GPU is at hand, rehearsed without one."""

import importlib.util
import json
import sys
from types import SimpleNamespace

import pytest
from scripts import script


@pytest.fixture
def check(gpu, monkeypatch):
    """The script, with a block of snow that is done in a moment."""
    with script("tools/gpu", "speeds") as speeds, script("tools/gpu", "check") as module:
        monkeypatch.setattr(speeds, "TINY", {"1k": (3, 3, 3)})
        for name in ("WARM", "STEPS", "BATCHES"):
            monkeypatch.setattr(speeds, name, 2)
        monkeypatch.setitem(sys.modules, "speeds", speeds)
        yield module


def test_rehearsal(check, tmp_path):
    """Every part that needs no real GPU is done and written down; nothing is left out."""
    report = check.Report(tmp_path / "gpu.json", minutes=5)
    check.check(report, stand_in=True)
    found = json.loads((tmp_path / "gpu.json").read_text())
    assert found["faults"] == {}
    assert found["left_out"] == []
    assert found["figures 1k"]["particles"] == 216
    assert found["figures 1k"]["finite"]
    assert "g2p2g" in found["fused 1k"]["kernel_ms"]
    assert max(found["agreement"]["float64"]["x"], found["agreement"]["float64"]["v"]) < 1e-12


def test_peers_do_the_same_snow(check):
    """Where a peer is installed it runs in turn with Neve, and what both make of the snow is compared."""
    for name in ("taichi", "warp"):
        found = check.peer(name, "cpu", "20k", 1, 300)
        if importlib.util.find_spec(name) is None:
            assert found == {"result": f"{name} is not installed"}
        else:
            assert found["same"]
            assert set(found["particle_steps_per_s"]) == {"neve", name}


def test_shares_of_the_peaks(check):
    """Of a GPU with 132 multiprocessors at 1.98 GHz and 6144 bits at 3.2 GHz, as its clocks have it."""
    speeds = sys.modules["speeds"]
    clocks = {13: 1_980_000, 36: 3_200_000, 37: 6144, 16: 132}
    peak = speeds.peaks(SimpleNamespace(architecture=90, attribute=clocks.__getitem__))
    assert peak["peak_GB_per_second"] == pytest.approx(4915.2)
    assert peak["peak_GFLOP_per_second"] == pytest.approx(66908.16)
    shares = speeds.shares(4e9, peak)
    assert shares == {
        "share_of_GB_per_second": pytest.approx(464 / 4915.2),
        "share_of_GFLOP_per_second": pytest.approx(8400 / 66908.16),
    }


def test_the_largest_block(check):
    """As many cells as memory and time leave room for."""
    found = {
        "memory_free": 1e11, "bytes_per_particle": 200.0, "particles": 10_000_000,
        "seconds_to_prepare": 8.0, "seconds_to_begin": 2.0,
    }  # fmt: skip
    speeds = sys.modules["speeds"]
    assert speeds.largest(found, 1e6) == (200, 200, int(0.9 * 1e11 / 200 / 320_000))
    assert speeds.largest(found, 40.0) == (200, 200, int(20e6 / 320_000))


def test_parts_that_do_not_fit_are_named(check, tmp_path):
    """And a fault in one part leaves the others alone."""
    report = check.Report(tmp_path / "gpu.json", minutes=1)
    report.part("long", 1e6, lambda: 1)
    report.part("wrong", 0, lambda: 1 / 0)
    report.part("right", 0, lambda: 2)
    assert report.found["left_out"] == ["long"]
    assert list(report.found["faults"]) == ["wrong"]
    assert report.found["right"] == 2
