"""Scenes and a stand-in simulation for the tests of running."""

from __future__ import annotations

import sys

import fake_neve
import pytest

from neve.run import painter
from neve.scene.reading.load import load

SCENE = """
about = "Test snow"

[run]
duration = 0.4
fps = 20

[[sources]]
shape = "sphere"

[[colliders]]
shape = "plane"
"""


@pytest.fixture
def scene_file(tmp_path):
    """A small scene of eight frames as a TOML file."""
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def scene(scene_file):
    """The same scene, loaded."""
    return load(scene_file)


@pytest.fixture
def fake(monkeypatch):
    """Replace the simulation and the drawing by stand-ins that take no time."""
    fake_neve.install(lambda name, module: monkeypatch.setitem(sys.modules, name, module))
    monkeypatch.setattr(painter, "SIZE", (64, 36))
    return fake_neve
