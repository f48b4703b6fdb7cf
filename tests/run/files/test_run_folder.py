"""Run folders and checkpoints: what is recognised, refused, replaced and never touched."""

import json
from pathlib import Path

import numpy as np
import pytest

from neve.io import checkpoint as checkpoints
from neve.io.checkpoint import read_checkpoint, write_checkpoint
from neve.io.errors import RunError
from neve.io.npz import write_npz
from neve.io.run_folder import RunFolder
from neve.run import run, run_scene

ARRAYS = {"x": np.arange(6, dtype=np.float32).reshape(2, 3), "time": 1 / 3, "steps": np.int64(7)}


@pytest.fixture
def finished(fake, scene, tmp_path):
    """The folder of a short finished run, with a note of the user in it."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, frames=2, quiet=True)
    (out / "notes.txt").write_text("mine")
    return out


def refusal(call, *arguments, **words):
    """The sentence of a refusal; it is one sentence."""
    with pytest.raises(RunError) as caught:
        call(*arguments, **words)
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence


def content(folder):
    return {path: path.read_bytes() for path in Path(folder).rglob("*") if path.is_file()}


def test_a_run_is_not_overwritten(finished, scene):
    """A folder that holds a run is refused, naming both ways on, and stays as it is."""
    before = content(finished)
    sentence = refusal(run_scene, scene, finished, quiet=True)
    assert "--resume" in sentence
    assert "--force" in sentence
    assert content(finished) == before


def test_force_replaces_the_run_and_nothing_else(finished, scene):
    """--force removes the files of the run, not those of the user."""
    run_scene(scene, finished, frames=1, force=True, quiet=True)
    assert sorted(p.name for p in (finished / "frames").iterdir()) == ["000000.npz", "000001.npz"]
    assert (finished / "notes.txt").read_text() == "mine"
    assert read_checkpoint(finished / "checkpoint").frame == 1


def test_force_keeps_the_run_if_the_new_one_cannot_start(finished, scene, fake, monkeypatch):
    """The old run goes only when the new simulation stands."""
    before = content(finished)
    monkeypatch.setattr(fake.Simulation, "__init__", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run_scene(scene, finished, force=True, quiet=True)
    assert content(finished) == before


def test_a_failed_start_leaves_no_folder(tmp_path, scene, fake, monkeypatch):
    """A run that never began leaves no empty folder behind."""
    monkeypatch.setattr(fake.Simulation, "__init__", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run_scene(scene, tmp_path / "new", quiet=True)
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("words", [{}, {"force": True}])
def test_other_peoples_folders_are_never_touched(tmp_path, fake, scene, words):
    """A folder with other files is refused with and without --force, even if it looks a little like a run."""
    (tmp_path / "scene.toml").write_text("about = 'mine'")
    (tmp_path / "frames").mkdir()
    before = content(tmp_path)
    assert "is not empty and is no Neve run" in refusal(run_scene, scene, tmp_path, quiet=True, **words)
    assert content(tmp_path) == before


def test_empty_folder_is_taken(tmp_path, fake, scene):
    """An empty folder is as good as none."""
    (tmp_path / "empty").mkdir()
    run_scene(scene, tmp_path / "empty", frames=1, quiet=True)
    assert RunFolder(tmp_path / "empty").is_run()


def test_places_that_are_no_run(tmp_path, fake, scene):
    """A file, nothing, and a folder without a run each get their sentence."""
    (tmp_path / "file").touch()
    (tmp_path / "empty").mkdir()
    assert "is a file" in refusal(run_scene, scene, tmp_path / "file", quiet=True)
    assert "is a file" in refusal(run_scene, scene, tmp_path / "file", resume=True, quiet=True)
    assert "does not exist" in refusal(run_scene, scene, tmp_path / "none", resume=True, quiet=True)
    assert "holds no Neve run" in refusal(run_scene, scene, tmp_path / "empty", resume=True, quiet=True)
    assert "a part of this path is a file" in refusal(run_scene, scene, tmp_path / "file" / "a", quiet=True)


def test_resume_and_force_exclude_each_other(finished, scene):
    """Asking for both is refused."""
    assert "choose one" in refusal(run_scene, scene, finished, resume=True, force=True, quiet=True)


@pytest.mark.parametrize(("version", "words"), [(0, "an older version"), (99, "a newer version")])
def test_run_of_another_version(finished, scene, version, words):
    """A folder of another format version is not resumed; --force may replace it."""
    (finished / "run.json").write_text(json.dumps({"run_format": version}))
    assert words in refusal(run_scene, scene, finished, resume=True, quiet=True)
    run_scene(scene, finished, frames=1, force=True, quiet=True)


def test_damaged_card(finished, scene):
    """A run.json that cannot be read is told."""
    (finished / "run.json").write_text("{")
    assert "run.json is damaged" in refusal(run_scene, scene, finished, resume=True, quiet=True)


def test_checkpoint_reads_back_exactly(tmp_path):
    """Every bit and every kind of value comes back."""
    path = tmp_path / "checkpoint"
    write_checkpoint(path, 4, 'about = "é"', "1.2", ARRAYS)
    back = read_checkpoint(path)
    assert (back.frame, back.scene, back.neve) == (4, 'about = "é"', "1.2")
    assert (back.arrays["time"], back.arrays["steps"]) == (1 / 3, 7)
    assert back.arrays["x"].tobytes() == ARRAYS["x"].tobytes()
    assert back.arrays["x"].dtype == np.float32


@pytest.mark.parametrize("keep", [0.0, 0.3, 0.9, 0.999])
def test_truncated_checkpoint(finished, scene, keep):
    """A checkpoint cut short anywhere is one sentence, and nothing else is touched."""
    path = finished / "checkpoint"
    path.write_bytes(path.read_bytes()[: int(keep * path.stat().st_size)])
    before = content(finished)
    assert "checkpoint is damaged" in refusal(run_scene, scene, finished, resume=True, quiet=True)
    assert content(finished) == before


def test_altered_checkpoint(finished, scene):
    """A single flipped bit in the particles is noticed."""
    path = finished / "checkpoint"
    data = bytearray(path.read_bytes())
    data[data.index(b"state.v.npy") + 200] ^= 1
    path.write_bytes(data)
    assert "checkpoint is damaged" in refusal(run_scene, scene, finished, resume=True, quiet=True)


def test_checkpoint_of_another_version(finished, scene, monkeypatch):
    """An older or newer checkpoint names both versions."""
    for version, words in ((0, "an older version of Neve (checkpoint format 0;"), (99, "a newer version")):
        with monkeypatch.context() as patch:
            patch.setattr(checkpoints, "FORMAT", version)
            write_checkpoint(finished / "checkpoint", 1, "", "0", ARRAYS)
        assert words in refusal(run_scene, scene, finished, resume=True, quiet=True)


def test_checkpoint_that_is_gone_or_foreign(finished, scene):
    """No checkpoint, and an archive of something else, are told."""
    path = finished / "checkpoint"
    with open(path, "wb") as file:
        write_npz(file, {"y": 1})
    assert "is damaged" in refusal(run_scene, scene, finished, resume=True, quiet=True)
    with open(path, "wb") as file:
        write_npz(file, {"checkpoint_format": checkpoints.FORMAT})
    assert "lacks parts of its state" in refusal(run_scene, scene, finished, resume=True, quiet=True)
    path.unlink()
    assert "does not exist" in refusal(run_scene, scene, finished, resume=True, quiet=True)


def test_scene_edited_in_the_folder_is_noticed(finished, fake, scene_file):
    """The checkpoint knows the scene it belongs to, so an edited scene.toml is not resumed."""
    from neve.scene.reading.load import load

    path = finished / "scene.toml"
    path.write_text(path.read_text().replace("xi = 10.0", "xi = 11.0"))
    assert "snow.xi is 10.0 there and 11.0 now" in refusal(
        run_scene, load(finished), finished, resume=True, quiet=True
    )


def test_full_disk_in_the_middle_of_a_run(fake, scene, tmp_path, monkeypatch):
    """A run that meets a full disk stops with one sentence and goes on from its checkpoint afterwards."""
    from neve.run.outputs import context

    straight, out = tmp_path / "straight", tmp_path / "full"
    run(fake.Simulation(scene), straight, quiet=True)
    real = context.write_stored

    def write(folder, frame, arrays):
        if frame == 3:
            raise RunError(f"{folder} could not be written: the disk is full.")
        return real(folder, frame, arrays)

    with monkeypatch.context() as patch:
        patch.setattr(context, "write_stored", write)
        assert "the disk is full" in refusal(run_scene, scene, out, quiet=True)
    run_scene(scene, out, resume=True, quiet=True)
    paths = [(out / "frames" / f"{k:06d}.npz", straight / "frames" / f"{k:06d}.npz") for k in range(9)]
    assert all(a.read_bytes() == b.read_bytes() for a, b in paths)
