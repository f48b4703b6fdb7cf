"""The cache folder: where it is, that it saves work, and that no harm to it stops a run."""

from __future__ import annotations

import os
from pathlib import Path

import meshes
import numpy as np
import pytest

from neve.geometry import cache, sdf
from neve.geometry.sdf import of_triangles
from neve.geometry.triangles import tidied


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A cache folder of its own."""
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def built(monkeypatch):
    """Count how often a grid is built; meshes in use are forgotten at once."""
    monkeypatch.setattr(sdf, "_in_use", {})
    count = []
    real = sdf.cache.keep
    monkeypatch.setattr(sdf.cache, "keep", lambda key, arrays: count.append(key) or real(key, arrays))
    return count


def made(radius=0.5, spacing=0.1):
    """A ball's grid of distances, as if in a process of its own, sampled at some points."""
    sdf._in_use.clear()
    ball = meshes.ball(radius, 1)
    mesh = of_triangles(tidied(np.asarray(ball.vertices), np.asarray(ball.faces)), spacing, 0.2)
    return np.asarray(mesh.sdf.sample(np.random.default_rng(0).uniform(-1, 1, (200, 3)))[0])


def test_where_the_folder_is(monkeypatch, tmp_path):
    """NEVE_CACHE, then XDG_CACHE_HOME, then ~/.cache; NEVE_CACHE set to nothing is none."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("NEVE_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert cache.folder() == tmp_path / ".cache/neve"
    monkeypatch.setenv("XDG_CACHE_HOME", "not/absolute")
    assert cache.folder() == tmp_path / ".cache/neve"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache.folder() == tmp_path / "xdg/neve"
    monkeypatch.setenv("NEVE_CACHE", "~/own")
    assert cache.folder() == tmp_path / "own"
    monkeypatch.setenv("NEVE_CACHE", "")
    assert cache.folder() is None
    assert cache.size() == 0


def test_a_grid_is_built_once(place, built):
    """The second time it comes from the folder with the same bits; other shapes and spacings are others."""
    first = made()
    assert np.array_equal(made(), first)
    assert len(built) == 1
    assert [path.suffix for path in place.iterdir()] == [".npz"]
    made(spacing=0.12)
    made(radius=0.4)
    assert len(set(built)) == len(built) == 3
    assert cache.size() == sum(path.stat().st_size for path in place.iterdir())


def test_meshes_in_use_are_shared(place):
    """Two bodies of one mesh share one grid as long as either lives."""
    ball = meshes.ball(0.5, 1)
    a, b = (
        of_triangles(tidied(np.asarray(ball.vertices), np.asarray(ball.faces)), 0.1, 0.2) for _ in range(2)
    )
    assert a is b


@pytest.mark.parametrize("damage", ["empty", "cut", "flipped", "foreign", "other"])
def test_a_damaged_file_is_made_again(place, built, damage, caplog):
    """Whatever became of the file: the grid is built anew, with the same bits, and kept."""
    first = made()
    [path] = place.iterdir()
    data = bytearray(path.read_bytes())
    if damage == "empty":
        path.write_bytes(b"")
    elif damage == "cut":
        path.write_bytes(data[: len(data) // 2])
    elif damage == "flipped":
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
    elif damage == "foreign":
        path.write_bytes(b"Dear snow")
    else:
        with open(path, "wb") as file:
            np.savez(file, table=np.zeros(3), sizes=np.zeros(2))
    assert np.array_equal(made(), first)
    assert len(built) == 2
    assert np.array_equal(made(), first)
    assert len(built) == 2


def test_a_folder_that_refuses_is_no_error(place, built, monkeypatch, caplog, tmp_path):
    """A file in its place, a full disk: the grid is there, and a line of the log says why it is not kept."""
    first = made()
    (tmp_path / "file").write_text("mine")
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "file"))
    assert np.array_equal(made(), first)
    assert "nothing is kept in the cache folder" in caplog.text
    caplog.clear()
    monkeypatch.setenv("NEVE_CACHE", str(tmp_path / "full"))

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    assert np.array_equal(made(), first)
    assert "nothing is kept in the cache folder" in caplog.text
    assert "No space left" in caplog.text
    assert list((tmp_path / "full").iterdir()) == []
    monkeypatch.setenv("NEVE_CACHE", "")
    caplog.clear()
    assert np.array_equal(made(), first)
    assert caplog.text == ""


def test_the_folder_does_not_grow_for_ever(place, built, monkeypatch):
    """Beyond the limit the file that was not used for longest goes, and never the newest."""
    made()
    [old] = place.iterdir()
    os.utime(old, (1, 1))
    made(radius=0.4)
    kept = set(place.iterdir())
    monkeypatch.setattr(cache, "LIMIT", int(2.5 * old.stat().st_size))
    made(radius=0.3)
    assert not old.exists()
    assert kept - {old} < set(place.iterdir())
    monkeypatch.setattr(cache, "LIMIT", 1)
    made(radius=0.2)
    assert [path.stem for path in Path(place).iterdir()] == [built[-1]]
