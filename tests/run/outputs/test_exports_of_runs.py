"""Files for other tools during a run: the same as afterwards, also when a run is stopped."""

import shutil

import pytest

from neve.export.run import Choices, export_run
from neve.io.errors import RunError
from neve.run import painter, run
from neve.scene.errors import SceneError
from neve.scene.reading.load import load
from neve.simulation import Simulation

SHORT = ("run.film=false", "run.fps=400", "run.duration=0.02")
ASKED = """
[numerics]
dx = 0.25
[[outputs]]
kind = "export"
to = "ply"
every_frames = 2

[[outputs]]
kind = "export"
to = "vtk"
name = "view"
fields = ["v", "m"]
up = "y"
scale = 10.0
"""


@pytest.fixture
def exporting(scene_file, monkeypatch):
    """The scene of eight frames, exported while it runs."""
    monkeypatch.setattr(painter, "SIZE", (64, 36))
    scene_file.write_text(scene_file.read_text() + ASKED)
    return load(scene_file, [*SHORT])


def files(folder):
    """Content of the files of an export."""
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.name != "export.json"}


def test_during_and_after_a_run_is_the_same(exporting, tmp_path):
    """To the byte; the next export of the run finds nothing to do."""
    out = tmp_path / "ball"
    run(Simulation(exporting), out, quiet=True)
    assert [name for name in files(out / "ply")] == [f"snow_{k:06d}.ply" for k in range(0, 9, 2)]
    afterwards, _ = export_run(out, Choices("ply"), tmp_path / "ply", slice(0, 9, 2))
    assert files(afterwards) == files(out / "ply")
    choices = Choices("vtk", ("v", "m"), "y", 10.0)
    afterwards, _ = export_run(out, choices, tmp_path / "vtk")
    assert files(afterwards) == files(out / "view")
    assert export_run(out, choices, out / "view")[1] == 0


def test_a_resumed_run_has_the_same_files(exporting, tmp_path):
    """Also where files of done frames are lost, and where later ones are there already."""
    run(Simulation(exporting), tmp_path / "whole", quiet=True)
    run(Simulation(exporting), tmp_path / "parts", frames=5, quiet=True)
    (tmp_path / "parts/ply/snow_000002.ply").unlink()
    shutil.rmtree(tmp_path / "parts/view")
    run(Simulation(exporting), tmp_path / "parts", resume=True, quiet=True)
    for name in ("ply", "view"):
        assert files(tmp_path / "parts" / name) == files(tmp_path / "whole" / name)


def test_a_run_that_replaces_another_removes_its_exports(exporting, scene_file, tmp_path):
    """And nothing else; a folder that is no export of the run is refused before anything is lost."""
    out = tmp_path / "ball"
    run(Simulation(exporting), out, quiet=True)
    (out / "ply/notes.txt").write_text("mine")
    run(Simulation(exporting), out, frames=3, force=True, quiet=True)
    assert sorted(files(out / "ply")) == ["notes.txt", "snow_000000.ply", "snow_000002.ply"]
    plain = load(scene_file, [*SHORT, "outputs=[]"])
    run(Simulation(plain), out, force=True, quiet=True)
    assert sorted(path.name for path in out.iterdir() if path.is_dir()) == ["frames", "ply"]
    assert [path.name for path in (out / "ply").iterdir()] == ["notes.txt"]
    with pytest.raises(RunError, match="ply is no file of the run and would be overwritten"):
        run(Simulation(exporting), out, force=True, quiet=True)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ('outputs.0.to="plyy"', r'outputs.0.to = "plyy" is not allowed \(did you mean "ply"\?\)'),
        ('outputs.0.up="x"', "outputs.0.up"),
        ("outputs.0.scale=0", "outputs.0.scale"),
        ('outputs.1.name="ply"', "must not be ply, which outputs.0 writes"),
        ('outputs.1.name="a/b"', "must be the name of a file"),
    ],
)
def test_wrong_entries_are_one_sentence(exporting, scene_file, change, sentence):
    """They are refused when the scene is read."""
    with pytest.raises(SceneError, match=sentence):
        load(scene_file, [change])


def test_what_shows_late_is_one_sentence(exporting, scene_file, tmp_path):
    """A field that the run does not have, and a format that cannot grow."""
    wrong = load(scene_file, [*SHORT, 'outputs.0.fields=["J_E"]'])
    with pytest.raises(RunError, match=r"there is no field J_E \(did you mean J_P\?\)"):
        run(Simulation(wrong), tmp_path / "a", quiet=True)
    pytest.importorskip("alembic3d")
    whole = load(scene_file, [*SHORT, 'outputs.0.to="abc"'])
    with pytest.raises(RunError, match="all frames in one file, which cannot grow during a run"):
        run(Simulation(whole), tmp_path / "b", quiet=True)
