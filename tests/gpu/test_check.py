"""The script for the day a GPU is at hand, rehearsed without one."""

import json
import sys

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
    assert max(found["agreement"]["float64"]["x"], found["agreement"]["float64"]["v"]) < 1e-12


def test_parts_that_do_not_fit_are_named(check, tmp_path):
    """And a fault in one part leaves the others alone."""
    report = check.Report(tmp_path / "gpu.json", minutes=1)
    report.part("long", 1e6, lambda: 1)
    report.part("wrong", 0, lambda: 1 / 0)
    report.part("right", 0, lambda: 2)
    assert report.found["left_out"] == ["long"]
    assert list(report.found["faults"]) == ["wrong"]
    assert report.found["right"] == 2
