"""A run folder is whole: what its scene names lies in it, by content, and it may be moved."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import meshes
import numpy as np
import pytest
import trimesh

from neve.io import assets
from neve.io.assets import assets_of, companions, same_content
from neve.io.errors import RunError
from neve.run import run, run_scene
from neve.sampling.fonts import FONT
from neve.scene.reading.load import load

SCENE = """
[run]
duration = 0.1
fps = 20
[[sources]]
shape = "text"
font = "letters.ttf"
[[colliders]]
shape = "mesh"
file = "rock.ply"
[[colliders]]
shape = "terrain"
file = "../hill.npy"
size = [4, 4]
[[colliders]]
shape = "mesh"
file = "again.ply"
"""


@pytest.fixture
def home(tmp_path):
    """A folder with a scene and all that it names; two of its meshes are the same."""
    place = tmp_path / "home"
    place.mkdir()
    (place / "scene.toml").write_text(SCENE)
    shutil.copy(FONT, place / "letters.ttf")
    meshes.written(meshes.box(1, 1, 1), place / "rock.ply")
    shutil.copy(place / "rock.ply", place / "again.ply")
    np.save(tmp_path / "hill.npy", np.zeros((3, 3)))
    return place


@pytest.fixture
def finished(home, fake, tmp_path):
    """The folder of a short run of that scene."""
    run(fake.Simulation(load(home / "scene.toml")), tmp_path / "out", frames=1, quiet=True)
    return tmp_path / "out"


def names(folder):
    return sorted(path.name for path in (folder / "assets").iterdir())


def test_files_lie_in_the_run(home, finished, tmp_path):
    """Font, meshes and map lie in assets/ with their bytes; scene.toml calls them by relative names."""
    text = (finished / "scene.toml").read_text()
    assert str(tmp_path) not in text
    kept = load(finished / "scene.toml")
    before = load(home / "scene.toml")
    for now, then in zip([*kept.colliders], [*before.colliders], strict=True):
        assert Path(now.file).parent == finished / "assets"
        assert Path(now.file).read_bytes() == Path(then.file).read_bytes()
    assert Path(kept.sources[0].font).read_bytes() == FONT.read_bytes()
    assert [name.rpartition("-")[0] for name in names(finished)] == ["again", "hill", "letters", "rock"]


def test_a_run_moves(finished, fake, tmp_path):
    """Without its origin and under another name the run goes on, and runs again to the same frames."""
    moved = tmp_path / "elsewhere" / "moved"
    moved.parent.mkdir()
    finished.rename(moved)
    shutil.rmtree(tmp_path / "home")
    (tmp_path / "hill.npy").unlink()
    run_scene(load(moved), moved, resume=True, quiet=True)
    run_scene(load(moved), tmp_path / "again", quiet=True)
    assert names(tmp_path / "again") == names(moved)
    for frame in ("000000.npz", "000002.npz"):
        assert (tmp_path / "again/frames" / frame).read_bytes() == (moved / "frames" / frame).read_bytes()


def test_a_run_replaced_by_itself_keeps_its_files(finished):
    """--force on the folder whose scene it is: the files are there, and no others."""
    before = names(finished)
    run_scene(load(finished), finished, frames=1, force=True, quiet=True)
    assert names(finished) == before


def test_a_run_replaced_by_another_drops_its_files(finished, scene):
    """--force with a scene without files clears assets/, but never what the user put there."""
    (finished / "assets/notes.txt").write_text("mine")
    run_scene(scene, finished, frames=1, force=True, quiet=True)
    assert names(finished) == ["notes.txt"]
    (finished / "assets/notes.txt").unlink()
    run_scene(scene, finished, frames=1, force=True, quiet=True)
    assert not (finished / "assets").exists()


def test_resume_compares_contents(home, finished, tmp_path):
    """Files that have moved or changed their names do not matter; one that has changed does."""
    (home / "rock.ply").rename(home / "stone.ply")
    text = SCENE.replace("rock.ply", "stone.ply").replace("../hill.npy", "hill.npy")
    (tmp_path / "hill.npy").rename(home / "hill.npy")
    (home / "scene.toml").write_text(text)
    run_scene(load(home / "scene.toml"), finished, resume=True, quiet=True)
    assert "assets/stone-" in (finished / "scene.toml").read_text()
    meshes.written(meshes.box(1, 1, 2), home / "stone.ply")
    with pytest.raises(RunError, match=r"was made with another scene \(colliders\.0\.file is 'assets/stone-"):
        run_scene(load(home / "scene.toml"), finished, resume=True, quiet=True)


def test_resume_notices_a_file_changed_in_the_run(finished):
    """A kept file that somebody edits is another file."""
    path = next((finished / "assets").glob("hill-*.npy"))
    np.save(path, np.ones((3, 3)))
    with pytest.raises(RunError, match=r"another scene \(colliders\.1\.file is"):
        run_scene(load(finished), finished, resume=True, quiet=True)


def test_resume_restores_a_lost_file(home, finished):
    """A kept file that is gone comes back from where the scene of the resume has it."""
    before = names(finished)
    shutil.rmtree(finished / "assets")
    run_scene(load(home / "scene.toml"), finished, resume=True, quiet=True)
    assert names(finished) == before


def test_a_file_lost_before_the_run(home, fake, tmp_path):
    """A file that goes between loading and running is one sentence, and leaves no folder."""
    scene = load(home / "scene.toml")
    (home / "rock.ply").unlink()
    with pytest.raises(RunError, match=r"rock\.ply could not be read: it does not exist\.$"):
        run(fake.Simulation(scene), tmp_path / "out", quiet=True)
    assert not (tmp_path / "out").exists()


def test_a_full_disk_leaves_no_half_file(home, fake, tmp_path, monkeypatch):
    """Copies are whole or not there."""

    def full(path, data):
        raise RunError(f"{path} could not be written: the disk is full.")

    scene = load(home / "scene.toml")
    with monkeypatch.context() as patch:
        patch.setattr(assets, "write_bytes", full)
        with pytest.raises(RunError, match="the disk is full"):
            run(fake.Simulation(scene), tmp_path / "out", quiet=True)
    assert not list((tmp_path / "out").glob("assets/*"))
    run_scene(scene, tmp_path / "out", force=True, quiet=True)
    assert len(names(tmp_path / "out")) == 4


def test_files_that_a_file_names_come_along(tmp_path, fake):
    """A glTF file brings its buffers, in their places; pictures, and what is not there, stay behind."""
    place = tmp_path / "model"
    place.mkdir()
    for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(meshes.box(1, 1, 1))).items():
        (place / name).write_bytes(data)
    path = place / "model.gltf"
    tables = json.loads(path.read_text())
    buffer = tables["buffers"][0]["uri"]
    (place / "more").mkdir()
    (place / buffer).rename(place / "more" / "a.bin")
    tables["buffers"][0]["uri"] = "more/a.bin"
    path.write_text(json.dumps(tables))
    assert companions(path) == [place / "more/a.bin", place / "gltf_buffer_1.bin"]
    (tmp_path / "a.toml").write_text(
        '[run]\nduration = 0.1\n[[sources]]\nshape = "box"\n'
        '[[colliders]]\nshape = "mesh"\nfile = "model/model.gltf"\n'
    )
    run(fake.Simulation(load(tmp_path / "a.toml")), tmp_path / "out", frames=1, quiet=True)
    [kept] = (tmp_path / "out/assets").iterdir()
    assert sorted(p.relative_to(kept).as_posix() for p in kept.rglob("*")) == [
        "gltf_buffer_1.bin",
        "model.gltf",
        "more",
        "more/a.bin",
    ]
    shutil.rmtree(tmp_path / "model")
    run_scene(load(tmp_path / "out"), tmp_path / "out", resume=True, quiet=True)
    run_scene(load(tmp_path / "out"), tmp_path / "more", frames=1, quiet=True)
    assert [p.name for p in (tmp_path / "more/assets").iterdir()] == [kept.name]


def test_own_files_keep_their_names(home, fake, tmp_path, monkeypatch):
    """What comes with Neve is called neve:NAME in the run as well, and is not copied."""
    from neve.scene.reading import files

    monkeypatch.setattr(files, "ASSETS", tmp_path)
    (tmp_path / "meshes").mkdir()
    meshes.written(meshes.box(1, 1, 1), tmp_path / "meshes/rock.ply")
    path = tmp_path / "a.toml"
    path.write_text('[[sources]]\nshape = "box"\n[[colliders]]\nshape = "mesh"\nfile = "neve:rock"\n')
    scene = load(path)
    assert assets_of(scene) == []
    run(fake.Simulation(scene), tmp_path / "out", frames=1, quiet=True)
    assert load(tmp_path / "out") == scene
    assert not (tmp_path / "out/assets").exists()
    path.write_text(path.read_text().replace("neve:rock", "neve:rok"))
    with pytest.raises(
        ValueError, match=r'"neve:rok" does not come with Neve \(did you mean "neve:rock"\?\)'
    ):
        load(path)


@pytest.mark.parametrize(
    ("before", "now", "same"),
    [
        ("assets/a-0123456789ab.ply", "assets/b-0123456789ab.ply", True),
        ("assets/a-0123456789ab.ply", "assets/a-0123456789ac.ply", False),
        ("assets/a-0123456789ab/x/a.gltf", "assets/b-0123456789ab/x/a.gltf", True),
        ("assets/a.ply", "assets/a.ply", False),
        (1.0, 2.0, False),
        ("assets/a-0123456789ab.ply", None, False),
    ],
)
def test_names_that_stand_for_the_same(before, now, same):
    """The hash decides, and only names of kept files have one."""
    assert same_content(before, now) is same
