"""Dotted paths into tables, lists and parts of a scene."""

import pytest

from neve.scene.reading.paths import follow, is_index
from neve.scene.schema.scene import Scene, Source

TREE = {"sources": [{"radius": 0.3}, {"radius": 0.4}], "snow": {"xi": 10}}


def test_tables_lists_and_parts_are_followed():
    """Words pick from tables and parts, numbers from lists and tuples; no words lead nowhere else."""
    scene = Scene(sources=(Source.of("sphere", radius=0.25),))
    assert follow(TREE, ["sources", "1", "radius"]) == 0.4
    assert follow(scene, ["sources", "0", "radius"]) == 0.25
    assert follow(TREE, []) is TREE


@pytest.mark.parametrize(
    "path", ["sources.2", "sources.-1", "sources.one", "snow.xi.0", "nothing", "sources.0.x"]
)
def test_what_is_not_there_is_a_key_error(path):
    """No path leads beyond the end of a list, into a single value, or to a key that is missing."""
    with pytest.raises(KeyError):
        follow(TREE, path.split("."))
    with pytest.raises(KeyError):
        follow(Scene(sources=(Source.of("sphere"),)), ["sources", "0", "no_such_key"])


def test_an_index_is_written_in_plain_digits():
    """Digits of other scripts are no numbers of entries."""
    assert is_index("1", [0, 0])
    assert not any(is_index(key, [0, 0]) for key in ("2", "-1", "", "\u0661"))
