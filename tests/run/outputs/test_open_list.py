"""`[[outputs]]`: what is written when, and that nothing is lost or doubled when a run is stopped."""

import csv
import signal
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import fake_neve
import numpy as np
import pytest
from patience import PATIENCE

from neve.io.errors import RunError
from neve.io.frames import frame_numbers
from neve.run import run, run_scene
from neve.run.outputs.film import FilmOutput
from neve.run.outputs.fragments import count_run
from neve.run.outputs.registry import BUILT_IN, entries, kinds
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, to_toml

LISTED = """
[[outputs]]
kind = "frames"
every_frames = 3

[[outputs]]
kind = "film"
every_seconds = 0.1

[[outputs]]
kind = "film"
name = "side.mp4"
camera = { position = [9.0, 0.0, 1.0], follow = "snow", follow_time = 0.12 }

[[outputs]]
kind = "fragments"
every_frames = 2
least = 3

[[outputs]]
kind = "log"
every_seconds = 0.2
"""
TABLES = ("fragments.csv", "log.csv", "solids.csv")


@pytest.fixture
def listed(scene_file):
    """The scene of eight frames, 20 per second, with a list of outputs."""
    scene_file.write_text(scene_file.read_text() + LISTED)
    return load(scene_file, ["numerics.dx=0.5"])


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def frames_of(path):
    """The numbers of the frames that have rows, in order, each once."""
    return list(dict.fromkeys(int(row["frame"]) for row in rows(path)))


def content(out):
    """The bytes of all that a run writes, but for wall times and the checkpoint."""
    found = {path.name: path.read_bytes() for path in (out / "frames").iterdir()}
    found |= {path.name: path.read_bytes() for path in out.glob("*.mp4")}
    for name in TABLES:
        found[name] = [{k: v for k, v in row.items() if "seconds" not in k} for row in rows(out / name)]
    return found | {"picture": (out / "preview.png").read_bytes()}


def test_each_output_keeps_its_schedule(fake, listed, tmp_path):
    """Frames, films and tables hold the frames that are due; what is not listed is written at each frame."""
    out = tmp_path / "ball"
    run(fake.Simulation(listed), out, quiet=True)
    assert frame_numbers(out / "frames") == [0, 3, 6]
    assert len((out / "preview.mp4").read_text().splitlines()) == 5  # 0, 0.1, ... 0.4 s
    assert len((out / "side.mp4").read_text().splitlines()) == 9
    assert frames_of(out / "fragments.csv") == [0, 2, 4, 6, 8]
    assert frames_of(out / "log.csv") == [0, 4, 8]
    assert frames_of(out / "solids.csv") == list(range(9))
    assert load(out / "scene.toml") == listed


@pytest.mark.parametrize("stops", [[1], [3], [2, 2, 5, 7]])
def test_stopped_and_resumed_is_the_same(fake, listed, tmp_path, stops):
    """Wherever a run is stopped, resuming leaves the same bytes: no frame or row is lost or doubled."""
    straight, parted = tmp_path / "straight", tmp_path / "parted"
    run(fake.Simulation(listed), straight, quiet=True)
    run(fake.Simulation(listed), parted, frames=stops[0], quiet=True)
    for stop in [*stops[1:], None, None]:
        run(fake.Simulation(listed), parted, frames=stop, resume=True, quiet=True)
    assert content(parted) == content(straight)


def test_killed_run_resumes(fake, listed, scene_file, tmp_path, monkeypatch):
    """SIGKILL with frames in the film that have no file of their own: they are drawn again from copies."""
    scene_file.write_text(to_toml(listed))
    straight, out = tmp_path / "straight", tmp_path / "killed"
    run_scene(listed, straight, quiet=True)
    program = (
        "import sys, fake_neve; fake_neve.install(); from neve.run import painter; painter.SIZE = (64, 36);"
        "real = fake_neve.Simulation.advance\n"
        "def advance(self, seconds):\n"
        "    real(self, seconds)\n"
        "    if self.steps == 20: import os, signal; os.kill(os.getpid(), signal.SIGKILL)\n"
        "fake_neve.Simulation.advance = advance\n"
        "from neve import schedule; schedule.EveryWallSeconds.due = lambda self, frame: True\n"
        "from neve.cli import main; main()"
    )
    command = [sys.executable, "-c", program, "run", str(scene_file), "--out", str(out), "--quiet"]
    done = subprocess.run(command, cwd=Path(fake_neve.__file__).parent, check=False, timeout=PATIENCE)
    assert done.returncode == -signal.SIGKILL
    assert frame_numbers(out / ".side.mp4.parts") in ([1, 2], [1, 2, 4])  # the last may not be written yet
    run_scene(listed, out, resume=True, quiet=True)
    assert content(out) == content(straight)


def test_a_film_needs_its_frames_again(fake, listed, tmp_path):
    """Another light needs a film drawn anew, for which a run with few frames has no files: one sentence."""
    out = tmp_path / "ball"
    run(fake.Simulation(listed), out, frames=4, quiet=True)
    (out / ".side.mp4.parts/000001.npz").unlink()
    darker = listed.model_copy(update={"light": listed.light.model_copy(update={"sun_strength": 0.5})})
    with pytest.raises(RunError, match=r"side\.mp4 needs frame 1 again, which the run keeps no file of"):
        run_scene(darker, out, resume=True, quiet=True)


def test_changed_list_is_another_scene(fake, listed, scene_file, tmp_path):
    """A resumed run keeps its schedules; the sentence names the first key that differs."""
    out = tmp_path / "ball"
    run(fake.Simulation(listed), out, frames=4, quiet=True)
    with pytest.raises(RunError, match=r"outputs\.0\.every_frames is 3 there and 2 now"):
        run_scene(
            load(scene_file, ["numerics.dx=0.5", "outputs.0.every_frames=2"]), out, resume=True, quiet=True
        )


def test_force_removes_what_outputs_wrote(fake, listed, tmp_path):
    """Replacing the run removes films and tables of any name, and nothing of the user's."""
    out = tmp_path / "ball"
    run(fake.Simulation(listed), out, frames=3, quiet=True)
    (out / "notes.csv").write_text("mine")
    plain = listed.model_copy(update={"outputs": ()})
    run(fake.Simulation(plain), out, frames=1, force=True, quiet=True)
    assert not list(out.glob("*side.mp4*"))
    assert not (out / "fragments.csv").exists()
    assert (out / "notes.csv").read_text() == "mine"


def test_short_keys_mean_entries(fake, scene_file, tmp_path):
    """`run.fragments = true` and an entry without a schedule leave the same bytes; so does a film."""
    kept = load(scene_file, ["run.fragments=true", "numerics.dx=0.5"])
    scene_file.write_text(
        scene_file.read_text() + '[[outputs]]\nkind = "fragments"\n[[outputs]]\nkind = "film"\n'
    )
    entry = load(scene_file, ["run.film=false", "numerics.dx=0.5"])
    run(fake.Simulation(kept), tmp_path / "short", quiet=True)
    run(fake.Simulation(entry), tmp_path / "entry", quiet=True)
    for name in ("fragments.csv", "preview.mp4"):
        assert (tmp_path / "short" / name).read_bytes() == (tmp_path / "entry" / name).read_bytes()


def test_counting_afterwards_keeps_what_the_run_wrote(fake, listed, tmp_path):
    """With a file for each frame that is due, counting gives the run's own table; without, it is refused."""
    out = tmp_path / "ball"
    _, *others = listed.outputs
    run(fake.Simulation(listed.model_copy(update={"outputs": tuple(others)})), out, quiet=True)
    before = (out / "fragments.csv").read_bytes()
    count_run(out)
    assert (out / "fragments.csv").read_bytes() == before
    run(fake.Simulation(listed), out, force=True, quiet=True)
    with pytest.raises(RunError, match="rows of frames which the run keeps no files of"):
        count_run(out)
    assert (out / "fragments.csv").read_bytes() == before
    count_run(out, out=tmp_path / "other.csv")
    assert frames_of(tmp_path / "other.csv") == [0, 3, 6]


@pytest.fixture
def rates(fake, monkeypatch):
    """The pictures per second of each film that is begun, by its name."""
    found = {}
    real = fake.Film.__init__

    def init(self, path, fps, size, start=0):
        found[Path(path).name] = fps
        real(self, path, fps, size, start)

    monkeypatch.setattr(fake.Film, "__init__", init)
    return found


def test_film_plays_as_fast_as_the_snow_moved(fake, listed, tmp_path, rates):
    """A film of every second frame of 20 per second has 10 pictures per second; the other one has 20."""
    run(fake.Simulation(listed), tmp_path / "ball", frames=1, quiet=True)
    assert rates == {"preview.mp4": Fraction(10), "side.mp4": Fraction(20)}


def test_films_have_their_own_cameras(fake, listed, tmp_path, monkeypatch):
    """The film of an entry is seen from its camera, the picture and the other film from the scene's."""
    seen = []
    real = fake_neve.Preview.__init__

    def init(self, scene, *size, threads=0, **rest):
        seen.append(scene.camera.position[0])
        real(self, scene, *size, threads=threads)

    monkeypatch.setattr(fake_neve.Preview, "__init__", init)
    run(fake.Simulation(listed), tmp_path / "ball", quiet=True)
    assert sorted(seen) == [4.0, 4.0, 9.0]


def test_two_outputs_of_one_file(fake, scene, tmp_path):
    """A film given as an object beside the run's own of that name is refused before anything is filmed."""
    with pytest.raises(RunError, match=r"two outputs of the run write preview\.mp4"):
        run(fake.Simulation(scene), tmp_path / "ball", quiet=True, outputs=[FilmOutput()])


def test_a_run_is_replaced_only_by_one_that_can_begin(fake, scene, tmp_path):
    """With --force outputs that cannot be are refused before the old run is removed."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, quiet=True)
    before = {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()}
    with pytest.raises(RunError, match="two outputs of the run"):
        run(fake.Simulation(scene), out, force=True, quiet=True, outputs=[FilmOutput()])
    assert {path.name: path.read_bytes() for path in out.iterdir() if path.is_file()} == before


@pytest.mark.parametrize("name", ["scene.toml", "log.csv", "run.json", "checkpoint", "preview.mp4"])
def test_fragments_are_not_counted_into_a_file_of_the_run(fake, scene, tmp_path, name):
    """`neve fragments RUN --out RUN/scene.toml` would destroy the run."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, quiet=True)
    before = (out / name).read_bytes()
    with pytest.raises(RunError, match="belongs to the run"):
        count_run(out, out=out / name)
    assert (out / name).read_bytes() == before


def test_film_of_a_picture_in_half_an_hour(fake, scene_file, tmp_path, rates):
    """However rare its pictures are, a film has a rate that its format can hold."""
    text = '[[outputs]]\nkind = "film"\nname = "rare.mp4"\nevery_seconds = 2000\n'
    scene_file.write_text(scene_file.read_text() + text)
    run(fake.Simulation(load(scene_file)), tmp_path / "ball", frames=1, quiet=True)
    assert rates["rare.mp4"] == Fraction(1, 1000)


def test_registry_is_complete(scene):
    """Each built-in kind has options that name it; without a list a scene has all that need no asking."""
    assert tuple(kinds()) == BUILT_IN
    for name, kind in kinds().items():
        assert kind.options().kind == name
        assert kind.options().file()
    asked_for = ("fragments", "export")
    assert [given.kind for given in entries(scene)] == [name for name in BUILT_IN if name not in asked_for]


WRONG = {
    'kind = "flim"': 'kind = "flim" is not allowed (did you mean "film"?): use "frames", "picture", "film"',
    "every_frames = 2": 'outputs.0 has no kind; add kind = "frames", "picture"',
    'kind = "log"\nevery_frames = 2\nevery_seconds = 1.0': "it must not stand beside every_frames",
    'kind = "log"\nevery_frames = 0': "every_frames = 0 is not allowed: use a whole number at least 1",
    'kind = "log"\nevery_seconds = 0.04': "it must be at least 1 / run.fps = 0.05 [s]",
    'kind = "log"\nevry_frames = 2': "is not a known key of the output log (did you mean every_frames?)",
    'kind = "film"\nname = "../a.mp4"': "it must be the name of a file that ends in .mp4",
    'kind = "picture"\nname = "a.jpg"': "it must be the name of a file that ends in .png",
    'kind = "fragments"\nname = "log.csv"': "it must not be log.csv, which the output log writes",
    'kind = "log"\n[[outputs]]\nkind = "log"': "outputs.1 must not write what outputs.0 writes",
    'kind = "film"\n[[outputs]]\nkind = "film"': "outputs.1.name must not be preview.mp4",
    'kind = "film"\ncamera = { fov = 700 }': "outputs.0.camera.fov = 700 is not allowed: use a number",
}


@pytest.mark.parametrize("entry", WRONG, ids=[text[:40] for text in WRONG.values()])
def test_wrong_entries_are_one_sentence(scene_file, entry):
    """File, key, value, what is allowed."""
    scene_file.write_text(f"{scene_file.read_text()}\n[[outputs]]\n{entry}\n")
    with pytest.raises(SceneError) as error:
        load(scene_file)
    assert str(error.value).startswith(f"{scene_file}: outputs.")
    assert WRONG[entry] in str(error.value)
    assert "\n" not in str(error.value)


def test_unknown_kind_ends_the_command(scene_file, tmp_path, capsys):
    """`neve run` with an unknown kind: one sentence and exit code 2, and no folder."""
    from neve.cli import main

    scene_file.write_text(f'{scene_file.read_text()}\n[[outputs]]\nkind = "movie"\n')
    with pytest.raises(SystemExit) as stop:
        main(["run", str(scene_file), "--out", str(tmp_path / "ball")])
    assert stop.value.code == 2
    assert 'outputs.0.kind = "movie" is not allowed' in capsys.readouterr().err
    assert not (tmp_path / "ball").exists()


def test_list_is_kept_in_the_run(fake, listed, tmp_path):
    """The scene of the folder has the list as it was, with numbers that read back equal."""
    run(fake.Simulation(listed), tmp_path / "ball", frames=1, quiet=True)
    again = load(tmp_path / "ball")
    assert again.outputs == listed.outputs
    assert np.allclose(again.outputs[2].camera.position, (9.0, 0.0, 1.0))
