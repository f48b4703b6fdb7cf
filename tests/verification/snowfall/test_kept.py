"""A fall is counted once: the next time it comes from the cache folder, with the same bits."""

from pathlib import Path

import numpy as np
import pytest
from verification.snowfall.surfaces import box, ground

from neve import reproducible
from neve.scene.errors import SceneWarning
from neve.scene.schema import snowfall as schema
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall import cover as counting_code
from neve.snowfall import kept
from neve.snowfall.cover import Raster, let_fall
from neve.snowfall.surroundings import joined

PIECES = (ground(), box((-0.5, -0.5, 0.0), (0.5, 0.5, 0.8)))
RASTER = Raster.over((0.0, 0.0), (3.0, 2.0), 0.1)
FALL = Snowfall(rate=3.0, duration=5.0, size=(3.0, 2.0), steps=2, repose=50.0, tolerance=0.1)


@pytest.fixture
def counted(monkeypatch, tmp_path):
    """The seeds of the falls that are counted; a cache folder of its own, in which small falls are kept."""
    seeds = []

    def counting(fall, *others):
        seeds.append(fall.seed)
        return let_fall(fall, *others)

    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(kept, "let_fall", counting)
    monkeypatch.setattr(kept, "WORTH", 0)
    return seeds


def fallen(fall=FALL, pieces=PIECES, raster=RASTER):
    """The cover, from the cache or counted."""
    return kept.fallen_once(fall, joined(pieces), raster)


def same(a, b):
    """Whether two covers are the same to the bit, with their layers and books."""
    arrays = [(a.z, b.z), (a.depth, b.depth), (a.share, b.share)]
    arrays += list(zip(a.layers.arrays().values(), b.layers.arrays().values(), strict=True))
    return a.books == b.books and all(np.array_equal(p, q) for p, q in arrays)


def test_the_second_time_the_same_bits_are_there(counted):
    """Depths, layers with their ages, and books; the fall is not counted again."""
    first, again = fallen(), fallen()
    assert counted == [0]
    assert same(first, again)
    assert again.volume == first.volume
    assert again.layers.age.max() > 0.0


@pytest.mark.parametrize(
    "changes",
    [
        {"fall": FALL.model_copy(update={"seed": 1})},
        {"fall": FALL.model_copy(update={"repose": 51.0})},
        {"fall": FALL.model_copy(update={"wind": (0.0, 0.1)})},
        {"pieces": (ground(), box((-0.5, -0.5, 0.0), (0.5, 0.5, 0.81)))},
        {"pieces": PIECES[:1]},
        {"raster": Raster.over((0.0, 0.0), (3.0, 2.0), 0.125)},
        {"raster": Raster.over((0.1, 0.0), (3.0, 2.0), 0.1)},
    ],
)
def test_another_fall_is_counted(counted, changes):
    """Whatever it follows from is another: flakes, what they fall on, and where they are counted."""
    fallen()
    fallen(**changes)
    assert len(counted) == 2


def test_other_code_counts_again(counted, monkeypatch):
    """A change of the core or of how Neve counts makes what was kept useless."""
    fallen()
    monkeypatch.setattr(kept, "_code", lambda: "changed")
    fallen()
    assert len(counted) == 2


@pytest.mark.parametrize("follows", ["new_density", "open_depth"])
def test_what_follows_from_the_keys_is_in_the_hash(monkeypatch, follows):
    """Another law of the density or depth of new snow, with the same keys, is another fall."""
    key = kept.key_of(FALL, joined(PIECES), RASTER)
    monkeypatch.setattr(Snowfall, follows, 77.0)
    assert kept.key_of(FALL, joined(PIECES), RASTER) != key


@pytest.mark.parametrize("module", [counting_code, reproducible, schema], ids=lambda m: m.__name__)
def test_each_file_that_counts_is_in_the_hash(monkeypatch, module):
    """The package, the schema of a fall, and the products that it counts with."""
    code, read = kept._code.__wrapped__(), Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b"#" * (path == Path(module.__file__)))
    assert kept._code.__wrapped__() != code


def test_what_was_kept_warns_again(counted, monkeypatch):
    """Snow that still slides is told each time, whether it was counted or kept."""
    monkeypatch.setattr(counting_code, "MOST_PASSES", 0)
    for _ in range(2):
        with pytest.warns(SceneWarning, match="some snow still slides"):
            fallen()
    assert counted == [0]


@pytest.mark.parametrize("damage", ["empty", "cut", "other", "short", "books"])
def test_a_damaged_file_is_counted_again(counted, tmp_path, damage):
    """Whatever became of it, the cover is right, and kept anew."""
    first = fallen()
    [path] = (tmp_path / "cache").iterdir()
    data = path.read_bytes()
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    if damage == "empty":
        path.write_bytes(b"")
    elif damage == "cut":
        path.write_bytes(data[: len(data) // 2])
    else:
        if damage == "short":
            arrays["depth"] = arrays["depth"][:-1]
        elif damage == "books":
            arrays["books"] = np.array('{"fell": 1}')
        else:
            arrays = {"x": np.zeros(3)}
        with path.open("wb") as file:
            np.savez(file, **arrays)
    assert same(first, fallen())
    assert len(counted) == 2
    assert same(first, fallen())
    assert len(counted) == 2


def test_a_short_fall_is_not_kept(counted, monkeypatch, tmp_path):
    """What is counted in no time leaves no file."""
    monkeypatch.setattr(kept, "WORTH", 10**9)
    fallen()
    fallen()
    assert len(counted) == 2
    assert not list(tmp_path.glob("cache/*"))


def test_without_a_folder_each_is_counted(counted, monkeypatch):
    """NEVE_CACHE set to nothing switches it off."""
    monkeypatch.setenv("NEVE_CACHE", "")
    fallen()
    fallen()
    assert len(counted) == 2
