"""A scene as a person would write it: short, and the same."""

import tomllib

import pytest

from neve.scene.reading.load import load, scene_from, to_toml
from neve.scene.reading.presets import presets
from neve.scene.reading.short_toml import short_toml


@pytest.mark.parametrize("name", presets())
def test_it_is_the_same_scene_in_fewer_lines(name):
    """Every preset comes back equal, in at most half of the lines of the whole text."""
    scene = load(name)
    text = short_toml(scene)
    assert scene_from(tomllib.loads(text)) == scene
    assert len(text.splitlines()) <= 0.5 * len(to_toml(scene).splitlines())


def test_the_constants_of_a_kind_of_snow_are_left_out():
    """Those that differ from the kind's stay; the kind's own go, whatever the default of the key."""
    scene = load("throw_ball", ["snow={kind='powder', E0=3e5}"])
    assert tomllib.loads(short_toml(scene))["snow"] == {"kind": "powder", "E0": 3e5}
