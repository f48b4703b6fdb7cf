"""The picture of the rooms is what the imports say, and reads from the top down."""

import re
from pathlib import Path

import pytest
from architecture import BOX, PATH, Room, apart, arrows, picture, python_rooms, rows_of

ROOT = Path(__file__).parents[2]
LARGEST = 30_000  # bytes


def test_picture_is_up_to_date():
    """docs/images/architecture.svg is the drawn one; `python tools/architecture.py` writes it."""
    text = (ROOT / PATH).read_text(encoding="utf-8")
    assert text == picture()
    assert len(text.encode()) < LARGEST


def test_every_room_is_in_the_picture():
    """Each folder and module of the package, and each folder of the core, has a box with its name."""
    names = set(re.findall(r">([\w/]+)</text>", (ROOT / PATH).read_text(encoding="utf-8")))
    package = {p.stem for p in (ROOT / "src/neve").iterdir() if p.suffix == ".py" or any(p.glob("*.py"))}
    core = {f"core/{p.name}" for p in (ROOT / "core").iterdir() if p.is_dir()}
    assert names == (package - {"__init__", "__main__"}) | core


def test_only_imports_that_run_count():
    """The scene is used by many and uses no solver; types alone make no arrow."""
    rooms = python_rooms()
    assert "scene" in rooms["build"].uses
    assert not rooms["scene"].uses & {"simulation", "mpm", "run", "render"}


def house(**uses):
    return {name: Room(name, "", set(used)) for name, used in uses.items()}


def test_arrows_that_follow_from_others_are_left_out():
    """a -> c goes if a -> b -> c is there, whatever else leads to c."""
    rooms = house(a="bc", b="c", c="", d="c")
    assert arrows(rooms) == [("a", "b"), ("b", "c"), ("d", "c")]
    assert rows_of(rooms) == {"a": 0, "b": 1, "c": 2, "d": 0}


def test_a_circle_is_an_error():
    """Rooms that use one another have no order."""
    with pytest.raises(ValueError, match=r"in a circle: a, b$"):
        arrows(house(a="b", b="a", c="a"))


def test_boxes_do_not_touch():
    """Places keep their order and at least the width of a box, however close their ideal places are."""
    x = apart(["a", "b", "c"], {"a": 0.0, "b": 1.0, "c": 0.5})
    assert x["b"] - x["a"] > BOX[0]
    assert x["c"] - x["b"] > BOX[0]
