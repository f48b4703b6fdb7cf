"""The folder of an export: it goes on, begins anew, and touches nothing else; wrong input is one sentence."""

import json
import shutil

import numpy as np
import pytest

from neve.cli import main
from neve.export import run as export
from neve.export.formats.ply import Ply
from neve.export.registry import FORMATS
from neve.export.run import Choices, export_run
from neve.io.errors import RunError
from neve.io.frames import read_frame, write_frame


def stamps(folder):
    """When each file of a folder was written."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("snow*")}


def test_a_second_export_writes_what_is_missing_alone(run_path):
    """Nothing, then a file that was removed, then a frame that the run has written anew."""
    folder, new = export_run(run_path, Choices("ply"))
    before = stamps(folder)
    assert (new, len(before)) == (5, 5)
    assert export_run(run_path, Choices("ply"))[1] == 0
    (folder / "snow_000002.ply").unlink()
    assert export_run(run_path, Choices("ply"))[1] == 1
    content = read_frame(run_path / "frames", 3)
    write_frame(run_path / "frames", 3, content._replace(x=content.x + np.float32(1)))
    assert export_run(run_path, Choices("ply"))[1] == 1
    after = stamps(folder)
    assert {name for name in before if before[name] != after[name]} == {"snow_000002.ply", "snow_000003.ply"}


@pytest.mark.parametrize("to", ["ply", "vtk", "usd", "abc"])
def test_no_export_mixes_two_runs(run_path, to):
    """A shorter second run in the same folder: of the first nothing is left, in files, record and lists."""
    if FORMATS.get(to).package is not None:
        pytest.importorskip(FORMATS.get(to).package[0])
    folder, _ = export_run(run_path, Choices(to))
    for number in range(5):
        content = read_frame(run_path / "frames", number)
        write_frame(run_path / "frames", number, content._replace(x=content.x + np.float32(0.5)))
    for number in (3, 4):
        (run_path / f"frames/{number:06d}.npz").unlink()
    export_run(run_path, Choices(to), frames=slice(0, 2))
    card = json.loads((folder / "export.json").read_text())
    assert sorted(card["frames"]) == ["0", "1"]
    assert not [path.name for path in folder.iterdir() if path.stem[-6:] in ("000002", "000003", "000004")]
    assert not [name for name in card["files"] if "000003" in name]
    assert export_run(run_path, Choices(to))[1] == (3 if to == "abc" else 1)
    if to == "vtk":
        assert (folder / "snow.pvd").read_text().count("<DataSet") == 3


@pytest.mark.parametrize(
    ("to", "name"), [("usd", "solids.usdc"), ("usd", "snow.usda"), ("vtk", "solids_still.vtp")]
)
def test_a_lost_file_of_all_frames_is_made_again(run_path, to, name):
    """As one of a frame is, and after that nothing is missing."""
    if FORMATS.get(to).package is not None:
        pytest.importorskip(FORMATS.get(to).package[0])
    folder, _ = export_run(run_path, Choices(to))
    before = (folder / name).read_bytes()
    (folder / name).unlink()
    export_run(run_path, Choices(to))
    assert len((folder / name).read_bytes()) == pytest.approx(len(before), rel=0.01)
    assert export_run(run_path, Choices(to))[1] == 0


def test_an_export_that_is_stopped_goes_on(run_path, monkeypatch):
    """Ctrl-C in the middle of a frame leaves whole files; the next export makes the rest."""
    write = Ply.write

    def stopped(self, moment):
        write(self, moment)
        if moment.frame == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(Ply, "write", stopped)
    with pytest.raises(KeyboardInterrupt):
        export_run(run_path, Choices("ply"))
    monkeypatch.undo()
    folder = run_path / "ply"
    assert not list(folder.glob(".*"))
    assert export_run(run_path, Choices("ply"))[1] == 3
    assert export_run(run_path, Choices("ply"))[1] == 0


def test_force_removes_the_files_of_the_export_alone(run_path):
    """Notes of one's own stay; frames that are not asked for go."""
    folder, _ = export_run(run_path, Choices("ply"))
    (folder / "notes.txt").write_text("mine")
    export_run(run_path, Choices("ply", ("v",)), frames=slice(0, 2), force=True)
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["export.json", "notes.txt", "snow_000000.ply", "snow_000001.ply"]


WRONG = [
    (["--to", "plyy"], "--to: there is no format plyy (did you mean ply?)"),
    (["--to", "ply", "--fields", "J_E"], "--fields: there is no field J_E (did you mean J_P?)."),
    (["--to", "ply", "--fields", "q"], "--fields: there is no field q (this run has v, J_P, id, material"),
    (["--to", "ply", "--frames", "5:9"], "RUN/frames holds the frames 0 to 4, and none of those asked for."),
    (["--to", "ply", "--frames", "3:x"], "--frames: 3:x is not of the form A:B or A:B:STEP, such as 0:50"),
    (["--to", "ply", "--frames", "0:4:0"], "--frames: 0:4:0 has a step of 0: use 1 or more"),
    (["--to", "ply", "--scale", "nan"], "--scale: nan is not a number from 1e-6 to 1e6"),
    (["--to", "ply", "--out", "RUN"], "RUN holds a run: choose another --out."),
    (["--to", "ply", "--out", "RUN/frames"], "RUN/frames holds files that are no export: choose another"),
    (["--to", "ply", "--out", "RUN/scene.toml"], "RUN/scene.toml is a file, and an export needs a folder"),
    (["--up", "y"], "TO is missing"),
]


@pytest.mark.parametrize(("options", "sentence"), WRONG, ids=[" ".join(options) for options, _ in WRONG])
def test_wrong_input_is_one_sentence(finished, capsys, options, sentence):
    """Exit code 2, and nothing is written."""
    before = sorted(finished.rglob("*"))
    given = [word.replace("RUN", str(finished)) for word in options]
    with pytest.raises(SystemExit) as end:
        main(["export", str(finished), *given])
    said = capsys.readouterr().err
    assert end.value.code == 2
    assert said.startswith("neve: ")
    assert said.count("\n") == 1
    assert sentence.replace("RUN", str(finished)) in said
    assert sorted(finished.rglob("*")) == before


def test_other_options_need_force(run_path):
    """An export with other fields, axes or scale is refused, and says what is there."""
    export_run(run_path, Choices("ply"))
    with pytest.raises(RunError, match=r"holds an export with up = z: replace it with --force"):
        export_run(run_path, Choices("ply", up="y"))


def test_what_is_no_run_or_damaged_is_refused(run_path, tmp_path):
    """No run, a run without frames, a damaged frame, a damaged record, a record that names other folders."""
    with pytest.raises(RunError, match="holds no Neve run"):
        export_run(tmp_path, Choices("ply"))
    folder, _ = export_run(run_path, Choices("ply"), frames=slice(1))
    card = json.loads((folder / "export.json").read_text())
    for content in (
        "{",
        "[]",
        json.dumps(card | {"files": ["../scene.toml"]}),
        json.dumps(card | {"frames": [1]}),
    ):
        (folder / "export.json").write_text(content)
        with pytest.raises(RunError, match=r"export\.json is damaged"):
            export_run(run_path, Choices("ply"), force=True)
    assert (run_path / "scene.toml").is_file()
    (run_path / "frames/000001.npz").write_bytes(b"no frame")
    with pytest.raises(RunError, match=r"000001\.npz is damaged"):
        export_run(run_path, Choices("ply"), tmp_path / "out")
    shutil.rmtree(run_path / "frames")
    with pytest.raises(RunError, match="holds no frames"):
        export_run(run_path, Choices("ply"), tmp_path / "other")


def test_a_full_disk_is_one_sentence(run_path, monkeypatch):
    """And what is there is whole."""

    def full(self, moment):
        with export_format.writing(self.path("x")):
            raise OSError(28, "No space left on device")

    from neve.export import format as export_format

    monkeypatch.setattr(Ply, "write", full)
    with pytest.raises(RunError, match="could not be written: the disk is full; what is exported already is"):
        export_run(run_path, Choices("ply"))


def test_the_command_says_what_it_did(run_path, capsys):
    """Folder and number of new frames on standard output, progress on standard error."""
    with pytest.raises(SystemExit) as end:
        main(["export", str(run_path), "--to", "ply", "--frames", "1:"])
    said = capsys.readouterr()
    assert end.value.code == 0
    assert said.out == f"{run_path}/ply: 4 new frames\n"
    assert "ply: frame 4 of 4" in said.err


def test_every_format_has_a_word_a_meaning_and_a_class():
    """Registry and command speak of the same formats."""
    assert set(FORMATS.meanings) == set(FORMATS.names())
    for name in FORMATS.names():
        assert issubclass(FORMATS.get(name), export.Format)
