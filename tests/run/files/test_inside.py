"""Nothing outside a run folder is written or deleted, and nothing in it that is not the run's."""

import json
import os
import sys
from pathlib import Path

import pytest

from neve.io.assets import Asset, keep_assets
from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.run import run, run_scene
from neve.scene.reading.load import load

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="symbolic links need rights there")

FILM = '\n[[outputs]]\nkind = "film"\nname = "side.mp4"\nevery_frames = 2\n'


@pytest.fixture
def out(fake, scene, tmp_path):
    """The folder of a run that was stopped after two of eight frames."""
    run(fake.Simulation(scene), tmp_path / "ball", frames=2, quiet=True)
    return tmp_path / "ball"


@pytest.fixture
def elsewhere(tmp_path):
    """A folder of the user, with files whose names Neve would write or delete."""
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    names = ["000000.npz", "000007.npz", "000000-000059.h264", "make", "rock-0123456789ab.ply", ".x.12.tmp"]
    for name in names:
        (folder / name).write_text(f"mine: {name}")
    return folder


def content(folder):
    """Every file below a folder with its bytes, links as where they point."""
    paths = sorted(Path(folder).rglob("*"))
    return {p: os.readlink(p) if p.is_symlink() else p.read_bytes() for p in paths if not p.is_dir()}


@pytest.mark.parametrize("words", [{"resume": True}, {"force": True}])
@pytest.mark.parametrize("part", ["frames", "assets", ".preview.mp4.parts"])
def test_a_part_that_is_a_link_is_refused(out, scene, elsewhere, part, words):
    """A folder of the run that leads elsewhere is one sentence; both sides stay as they were."""
    if (out / part).exists():
        (out / part).rename(out / f"{part}.old")
    (out / part).symlink_to(elsewhere)
    before = content(out), content(elsewhere)
    with pytest.raises(RunError, match=rf"{part} is a symbolic link, .* inside its own folder"):
        run_scene(scene, out, quiet=True, **words)
    assert (content(out), content(elsewhere)) == before


@pytest.mark.parametrize("words", [{"resume": True}, {"force": True}])
@pytest.mark.parametrize("hard", [False, True], ids=["symbolic", "hard"])
@pytest.mark.parametrize("name", ["log.csv", "checkpoint", "run.json", "scene.toml", "frames/000002.npz"])
def test_a_file_that_is_a_link_is_replaced(out, scene, elsewhere, name, words, hard):
    """A new file takes the place of the link; the file that it points to keeps its bytes."""
    target = elsewhere / "kept"
    (out / name).rename(target)
    if hard:
        (out / name).hardlink_to(target)
    else:
        (out / name).symlink_to(target)
    before = content(elsewhere)
    run_scene(scene, out, frames=4, quiet=True, **words)
    assert content(elsewhere) == before
    if name in ("log.csv", "checkpoint"):  # others are only read when a run is resumed
        assert not (out / name).is_symlink()


def test_a_stray_link_among_the_assets(fake, tmp_path, scene_file, elsewhere):
    """A link with the name of a kept file goes; what it points to stays."""
    out = tmp_path / "ball"
    run_scene(load(scene_file), out, frames=1, quiet=True)
    (out / "assets").mkdir()
    (out / "assets" / "stray-0123456789ab").symlink_to(elsewhere)
    before = content(elsewhere)
    run_scene(load(scene_file), out, resume=True, quiet=True)
    assert content(elsewhere) == before
    assert not (out / "assets").exists()


def test_a_link_inside_a_kept_folder(tmp_path, elsewhere):
    """A folder inside a kept folder, made a link, is refused."""
    (tmp_path / "a.obj").write_text("v 0 0 0")
    home = tmp_path / "ball" / "assets" / "robot-0123456789ab"
    home.mkdir(parents=True)
    (home / "sub").symlink_to(elsewhere)
    name = "assets/robot-0123456789ab/sub/a.obj"
    with pytest.raises(RunError, match="sub is a symbolic link"):
        keep_assets(tmp_path / "ball", [Asset(("robots",), name, ((tmp_path / "a.obj", name),))])
    assert not (elsewhere / "a.obj").exists()


def test_the_run_folder_itself_may_be_a_link(fake, scene, tmp_path):
    """A user who names a link means the folder behind it."""
    (tmp_path / "big disk").mkdir()
    (tmp_path / "ball").symlink_to(tmp_path / "big disk")
    run_scene(scene, tmp_path / "ball", frames=2, quiet=True)
    run_scene(scene, tmp_path / "ball", frames=3, resume=True, quiet=True)
    run_scene(scene, tmp_path / "ball", frames=1, force=True, quiet=True)
    assert sorted(p.name for p in (tmp_path / "big disk" / "frames").iterdir()) == [
        "000000.npz",
        "000001.npz",
    ]


def test_a_temporary_name_that_is_a_link(out, scene, elsewhere, monkeypatch):
    """Even the name of a temporary file, made a link in advance, leads nowhere."""
    monkeypatch.setattr("neve.system.disk._count", iter(range(10_000)))
    for number in range(40):
        (out / f".log.csv.{os.getpid()}-{number}.tmp").symlink_to(elsewhere / "make")
    before = content(elsewhere)
    monkeypatch.setattr("neve.system.disk.sweep", lambda folder: None)
    run_scene(scene, out, resume=True, quiet=True)
    assert content(elsewhere) == before


def test_force_leaves_nothing_of_the_old_run(fake, scene_file, tmp_path):
    """All files of the old run go, also those that the new one does not write; the user's stay."""
    scene_file.write_text(scene_file.read_text() + FILM)
    out = tmp_path / "ball"
    run_scene(load(scene_file), out, quiet=True)
    (out / "notes.txt").write_text("mine")
    scene_file.write_text(
        scene_file.read_text().replace(FILM, "").replace('[[colliders]]\nshape = "plane"', "")
    )
    run_scene(load(scene_file), out, frames=1, force=True, quiet=True)
    fresh = tmp_path / "fresh"
    run_scene(load(scene_file), fresh, frames=1, quiet=True)
    names = {p.relative_to(out) for p in out.rglob("*")} - {Path("notes.txt")}
    assert names == {p.relative_to(fresh) for p in fresh.rglob("*")}


@pytest.mark.parametrize("card", ['{"run_format": 1, "neve": "0"}', "{"])
def test_force_over_an_older_or_damaged_run(out, scene, card):
    """A card that lists nothing does not keep the files that every run had, then and now."""
    (out / "run.json").write_text(card)
    for name in ("bodies.csv", "fragments.csv"):
        (out / name).write_text("old")
    (out / "mine.csv").write_text("mine")
    run_scene(scene, out, frames=1, force=True, quiet=True)
    assert not (out / "bodies.csv").exists()
    assert not (out / "fragments.csv").exists()
    assert (out / "mine.csv").read_text() == "mine"


@pytest.mark.parametrize("words", [{"force": True}, {"resume": True}])
def test_a_file_of_the_user_is_not_written_over(fake, scene_file, tmp_path, words):
    """A new output whose file is there already, and not the run's, is one sentence."""
    out = tmp_path / "ball"
    run_scene(load(scene_file), out, frames=2, quiet=True)
    (out / "side.mp4").write_text("mine")

    class Rows:
        def write(self, context):
            context.add_row("side.mp4", {"count": 1})

        def close(self, context):
            pass

    before = content(out)
    if "force" in words:
        scene_file.write_text(scene_file.read_text() + FILM)
        with pytest.raises(RunError, match=r"side\.mp4 is no file of the run"):
            run_scene(load(scene_file), out, quiet=True, **words)
        assert content(out) == before
    else:
        with pytest.raises(RunError, match=r"side\.mp4 is no file of the run"):
            run(fake.Simulation(load(scene_file)), out, quiet=True, outputs=[Rows()], **words)
        assert (out / "side.mp4").read_text() == "mine"


class Fails:
    """An output that raises where it is told to."""

    def __init__(self, where):
        self.where = where

    def begin(self, run, schedule):
        if self.where == "begin":
            raise ZeroDivisionError

    def write(self, context):
        if self.where == context.frame:
            raise ZeroDivisionError

    def close(self, context):
        pass


@pytest.mark.parametrize("words", [{}, {"resume": True}, {"force": True}])
@pytest.mark.parametrize("where", ["begin", 0])
def test_a_run_that_failed_at_its_start_is_no_run_yet(fake, scene, tmp_path, where, words):
    """What fails before frame 0 is complete leaves a folder that the next run takes, by any command."""
    out, straight = tmp_path / "ball", tmp_path / "straight"
    with pytest.raises(ZeroDivisionError):
        run(fake.Simulation(scene), out, quiet=True, outputs=[Fails(where)])
    run_scene(scene, out, frames=3, quiet=True, **words)
    run_scene(scene, straight, frames=3, quiet=True)
    names = [{p.relative_to(folder) for p in folder.rglob("*")} for folder in (out, straight)]
    assert names[0] == names[1]
    assert json.loads((out / "run.json").read_text()) == json.loads((straight / "run.json").read_text())


def test_a_kill_before_the_card_is_there_leaves_a_free_folder(fake, scene, tmp_path):
    """A folder with nothing but what a killed write left is as good as an empty one."""
    out = tmp_path / "ball"
    out.mkdir()
    (out / ".run.json.77-0.tmp").write_text("{")
    run_scene(scene, out, frames=1, quiet=True)
    assert not list(out.glob(".*"))
    assert RunFolder(out).has_begun()
