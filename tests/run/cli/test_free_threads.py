"""How many threads `neve view` takes by default."""

import os

import pytest

from neve.system.processors import free_threads


def nothing():
    raise OSError


@pytest.mark.parametrize(
    ("cores", "load", "threads"), [(8, 0.1, 8), (8, 0.9, 7), (2, 6.0, 1), (1, 6.0, 1), (None, 0.0, 1)]
)
def test_all_unless_others_compute(monkeypatch, cores, load, threads):
    """All processors, or one less where others keep half of one busy; never none."""
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    monkeypatch.setattr(os, "getloadavg", lambda: (load, 0.0, 0.0))
    assert free_threads() == threads


def test_one_is_left_where_the_system_does_not_say(monkeypatch):
    """A system without a mean of its load is taken to be busy."""
    monkeypatch.setattr(os, "cpu_count", lambda: 4)
    monkeypatch.setattr(os, "getloadavg", nothing)
    assert free_threads() == 3
    monkeypatch.delattr(os, "getloadavg")
    assert free_threads() == 3
