"""The run loop: what it leaves behind, and that stopping and resuming change nothing."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import fake_neve
import numpy as np
import pytest
from patience import PATIENCE, wait_until

from neve import _core
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError
from neve.io.log import columns
from neve.io.version import build, version
from neve.run import loop, run, run_scene
from neve.run.outputs.picture import telling_frame
from neve.run.painter import Painter
from neve.scene.reading.load import load

FAKE = Path(fake_neve.__file__)


def frames(out):
    """The bytes of each frame file, by name."""
    return {path.name: path.read_bytes() for path in sorted((out / "frames").iterdir())}


def table(out):
    with open(out / "log.csv", newline="") as file:
        return list(csv.DictReader(file))


def physics(out):
    """The log without the wall times, which differ from run to run."""
    return [{k: v for k, v in row.items() if not k.startswith("seconds_")} for row in table(out)]


def start(out, scene_file, *words, pause=0.0):
    """Start the command line with the stand-in simulation in a process of its own."""
    environment = os.environ | {"NEVE_FAKE_PAUSE": str(pause)}
    command = [sys.executable, str(FAKE), "run", str(scene_file), "--out", str(out), *words]
    return subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True)


def end(process):
    """Wait for the process to end; return its exit code and what it said."""
    told = process.communicate(timeout=PATIENCE)[1]
    return process.returncode, told


def wait_for(path, process):
    """Wait until a running process has written a file."""
    wait_until(path.exists, process)


def test_folder_holds_everything(fake, scene, tmp_path):
    """A finished run has a scene that loads equal, frames, log rows, checkpoint, film and picture."""
    out = tmp_path / "ball"
    sim = run(fake.Simulation(scene), out, quiet=True)
    assert load(out / "scene.toml") == scene
    assert list(frames(out)) == [f"{k:06d}.npz" for k in range(9)]
    assert sorted(p.name for p in out.iterdir()) == sorted(
        [
            "run.json",
            "scene.toml",
            "log.csv",
            "solids.csv",
            "frames",
            "checkpoint",
            "preview.png",
            "preview.mp4",
        ]
    )
    assert len((out / "preview.mp4").read_text().splitlines()) == 9
    assert sim.time == pytest.approx(0.4)


def test_frames_are_float32_and_ordered_by_id(fake, scene, tmp_path):
    """Row k is particle k in every frame although the simulation shuffles them."""
    out = tmp_path / "ball"
    sim = run(fake.Simulation(scene), out, quiet=True)
    assert not np.array_equal(sim.state.id, np.arange(sim.count))
    with np.load(out / "frames/000008.npz") as frame:
        assert set(frame.files) == {
            "x",
            "v",
            "J_P",
            "id",
            "material",
            "solid_position",
            "solid_rotation",
            "time",
        }
        assert np.array_equal(frame["id"], np.arange(sim.count))
        assert np.array_equal(frame["x"], sim.state.x[np.argsort(sim.state.id)])
        assert {frame[name].dtype for name in ("x", "v", "J_P", "solid_position")} == {np.dtype(np.float32)}
        assert frame["solid_position"].shape == (1, 3)
        assert frame["solid_rotation"].shape == (1, 3, 3)
        assert frame["time"] == sim.time


def test_log_columns(fake, scene, tmp_path):
    """The log has the promised columns; the first row is the initial state, which took no step."""
    out = tmp_path / "ball"
    sim = run(fake.Simulation(scene), out, quiet=True)
    rows = table(out)
    assert tuple(rows[0]) == columns("mpm")
    assert [int(row["frame"]) for row in rows] == list(range(9))
    assert (rows[0]["dt_min"], rows[0]["bound"], rows[0]["steps"]) == ("", "", "0")
    assert (rows[8]["bound"], int(rows[8]["steps"]), int(rows[8]["particles"])) == ("speed", sim.steps, 50)
    assert float(rows[8]["kinetic"]) == sim.diagnostics().kinetic
    assert float(rows[8]["momentum_z"]) == sim.diagnostics().momentum[2]
    assert float(rows[8]["seconds_p2g"]) == 0.1
    assert all(float(row["seconds_write"]) > 0 for row in rows)


@pytest.mark.parametrize("stop", [1, 5])
def test_resumed_run_is_the_same_run(fake, scene, tmp_path, stop):
    """Stopping after a frame and resuming gives the bytes of the straight run: frames, film, log."""
    straight, parted = tmp_path / "straight", tmp_path / "parted"
    run(fake.Simulation(scene), straight, quiet=True)
    run(fake.Simulation(scene), parted, frames=stop, quiet=True)
    assert len(frames(parted)) == stop + 1
    run(fake.Simulation(scene), parted, resume=True, quiet=True)
    assert frames(parted) == frames(straight)
    assert physics(parted) == physics(straight)
    assert (parted / "preview.mp4").read_bytes() == (straight / "preview.mp4").read_bytes()
    assert (parted / "preview.png").read_bytes() == (straight / "preview.png").read_bytes()


def test_frames_after_the_checkpoint_are_rewritten(fake, scene, tmp_path):
    """Frames and rows that a crash left beyond the checkpoint are dropped and computed again."""
    out, straight = tmp_path / "crash", tmp_path / "straight"
    run(fake.Simulation(scene), straight, quiet=True)
    run(fake.Simulation(scene), out, frames=3, quiet=True)
    (out / "frames/000004.npz").write_bytes(b"half")
    (out / "frames/.000005.npz.99.tmp").write_bytes(b"half")
    with open(out / "log.csv", "a") as file:
        file.write("4,0.2,16,0.01,0.01,speed,1,1,1,1,1,1,1,50,7,0,0,0,0,0,0\n5,0.25,2")
    run_scene(scene, out, resume=True, quiet=True)
    assert frames(out) == frames(straight)
    assert physics(out) == physics(straight)


@pytest.fixture
def stop_after(fake, monkeypatch):
    """Return a function that makes the simulation press Ctrl-C while it computes frame k."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    real = fake.Simulation.advance

    def at(k):
        def advance(self, seconds):
            real(self, seconds)
            if self.steps == 4 * k:
                signal.raise_signal(signal.SIGINT)

        monkeypatch.setattr(fake.Simulation, "advance", advance)

    yield at
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def drawn(fake, monkeypatch):
    """The times [s] of the frames that are drawn, in order."""
    times = []
    real = Painter.draw
    monkeypatch.setattr(
        Painter, "draw", lambda self, content: times.append(content.time) or real(self, content)
    )
    return times


def test_stopped_film_goes_on(scene, tmp_path, stop_after, drawn):
    """A stop leaves the film of what is done and keeps its parts: only a lost frame is drawn again."""
    straight, out = tmp_path / "straight", tmp_path / "stopped"
    run(fake_neve.Simulation(scene), straight, quiet=True)
    stop_after(3)
    with pytest.raises(
        KeyboardInterrupt, match=f"stopped after frame 3 of 8; continue with: neve run {out} --resume"
    ):
        run(fake_neve.Simulation(scene), out, quiet=True)
    film = (out / "preview.mp4").read_text()
    assert len(film.splitlines()) == 4
    assert (straight / "preview.mp4").read_text().startswith(film)
    assert not (out / "preview.png").exists()
    (out / ".preview.mp4.parts/2.part").unlink()
    drawn.clear()
    run_scene(scene, out, resume=True, quiet=True)
    assert drawn[:-1] == pytest.approx([0.1, 0.2, 0.25, 0.3, 0.35, 0.4])
    assert (out / "preview.mp4").read_text() == (straight / "preview.mp4").read_text()
    assert not (out / ".preview.mp4.parts").exists()


def test_new_camera_films_anew(scene, scene_file, tmp_path, stop_after, drawn):
    """Going on with another camera draws the whole film again, so that it is one film."""
    out = tmp_path / "stopped"
    stop_after(3)
    with pytest.raises(KeyboardInterrupt):
        run(fake_neve.Simulation(scene), out, quiet=True)
    drawn.clear()
    run_scene(load(scene_file, ["camera.fov=20.0"]), out, resume=True, quiet=True)
    assert drawn[:-1] == pytest.approx([k / 20 for k in range(9)])


def test_error_leaves_the_film_so_far(fake, scene, tmp_path, monkeypatch):
    """A simulation that fails leaves film, frames and log of the frames before."""
    out = tmp_path / "failed"
    real = fake.Simulation.advance

    def advance(self, seconds):
        if self.steps == 12:
            raise RuntimeError("particle 7 lost its numbers")
        real(self, seconds)

    monkeypatch.setattr(fake.Simulation, "advance", advance)
    with pytest.raises(RuntimeError, match="particle 7"):
        run(fake.Simulation(scene), out, quiet=True)
    assert len((out / "preview.mp4").read_text().splitlines()) == len(frames(out)) == len(table(out)) == 4


def test_resume_of_a_finished_run_computes_nothing(fake, scene, tmp_path):
    """A finished run stays as it is, also when fewer frames are asked for; its film is drawn anew."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, quiet=True)
    before = frames(out)
    (out / "preview.mp4").unlink()
    sim = run_scene(scene, out, frames=2, resume=True, quiet=True)
    assert frames(out) == before
    assert len((out / "preview.mp4").read_text().splitlines()) == 9
    assert read_checkpoint(out / "checkpoint").frame == 8
    assert sim.steps == 32


def test_resume_with_another_scene_is_refused(fake, scene, scene_file, tmp_path):
    """What would move snow differently is named; what only changes length or looks is taken."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, frames=1, quiet=True)
    with pytest.raises(RunError, match=r"snow\.xi is 10\.0 there and 12(\.0)? now"):
        run_scene(load(scene_file, ["snow.xi=12"]), out, resume=True, quiet=True)
    with pytest.raises(RunError, match=r"colliders\.0\.mu_c is 0\.5 there and 0\.1 now"):
        run_scene(load(scene_file, ["colliders.0.mu_c=0.1"]), out, resume=True, quiet=True)
    longer = load(scene_file, ["run.duration=0.5", "camera.fov=20.0", "run.film=false"])
    run_scene(longer, out, resume=True, quiet=True)
    assert len(frames(out)) == 11
    assert load(out) == longer


def test_resume_under_another_version_is_told(fake, scene, tmp_path, monkeypatch, capsys):
    """One sentence says that the bits may differ; under the same version and build nothing does."""
    out = tmp_path / "ball"
    run(fake.Simulation(scene), out, frames=1)
    run_scene(scene, out, frames=2, resume=True)
    assert "bits may differ" not in capsys.readouterr().err
    monkeypatch.setattr(loop, "build", lambda: "99.0 (x86-64-v3)")
    run_scene(scene, out, frames=3, resume=True)
    told = [line for line in capsys.readouterr().err.splitlines() if "bits may differ" in line]
    assert len(told) == 1
    assert f"started with Neve {build()} and continues with 99.0 (x86-64-v3)" in told[0]
    assert build().startswith(f"{version()} ({_core.build_info()['isa']}, ")


def test_further_outputs_follow_their_schedule(fake, scene, tmp_path):
    """A further output sees the frames of its schedule, and the end."""

    class EveryThird:
        def due(self, frame):
            return frame % 3 == 0

    class Watch:
        schedule = EveryThird()
        seen, ended = [], None

        def write(self, context):
            self.seen.append((context.frame, context.sim.steps))

        def close(self, context):
            self.ended = context.frame

    watch = Watch()
    run(fake.Simulation(scene), tmp_path / "ball", quiet=True, outputs=[watch])
    assert (watch.seen, watch.ended) == ([(0, 0), (3, 12), (6, 24)], 8)


@pytest.mark.parametrize(
    ("sent", "expected"),
    [(["SIGINT"], {130}), (["SIGTERM", "SIGTERM"], {143}), (["SIGHUP", "SIGTERM"], {129, 143})],
)
def test_a_signal_finishes_the_frame(fake, scene_file, tmp_path, sent, expected):
    """Exit code 128 + the first one heard (two that wait at once come in any order), the checkpoint
    is at the last frame, the resumed bits are those of a straight run. A second SIGTERM, which `timeout`
    sends, is no hurry."""
    out, straight = tmp_path / "stopped", tmp_path / "straight"
    scene_file.write_text(scene_file.read_text().replace("duration = 0.4", "duration = 400"))
    process = start(out, scene_file, pause=0.1)
    wait_for(out / "frames/000001.npz", process)
    for name in sent:
        process.send_signal(getattr(signal, name))
    code, told = end(process)
    assert code in expected
    assert "Traceback" not in told
    assert f"continue with: neve run {out} --resume" in told.splitlines()[-1]
    done = len(frames(out)) - 1
    assert done >= 1
    assert read_checkpoint(out / "checkpoint").frame == done
    run_scene(load(out), out, frames=done + 2, resume=True, quiet=True)
    run_scene(load(scene_file), straight, frames=done + 2, quiet=True)
    assert frames(out) == frames(straight)


def test_second_ctrl_c_stops_at_once(scene_file, tmp_path):
    """Two SIGINTs end a frame that would take a minute, with exit code 130 and no temporary file."""
    out = tmp_path / "stopped"
    process = start(out, scene_file, pause=60)
    wait_for(out / "checkpoint", process)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert "finishing this frame" in next(line for line in process.stderr if line.startswith("finishing"))
    process.send_signal(signal.SIGINT)
    code, told = end(process)
    assert (code, "Traceback" in told) == (130, False)
    assert read_checkpoint(out / "checkpoint").frame == 0
    assert not list(out.rglob("*.tmp"))


def test_kill_leaves_a_run_that_resumes(fake, scene_file, tmp_path):
    """SIGKILL in the middle of it: nothing is half-written, and --resume gives the bits of a straight run."""
    out, straight = tmp_path / "killed", tmp_path / "straight"
    process = start(out, scene_file, pause=0.05)
    wait_for(out / "frames/000003.npz", process)
    process.kill()
    assert end(process)[0] == -signal.SIGKILL
    assert read_checkpoint(out / "checkpoint").frame <= 3
    assert end(start(out, scene_file, "--resume", "--quiet")) == (0, "")
    run_scene(load(scene_file), straight, quiet=True)
    assert frames(out) == frames(straight)
    assert physics(out) == physics(straight)


def test_two_processes_do_not_share_a_folder(fake, scene_file, tmp_path):
    """While one process runs in a folder another one is refused, and may have it when the first is gone."""
    out = tmp_path / "shared"
    first = start(out, scene_file, pause=60)
    wait_for(out / "checkpoint", first)
    with pytest.raises(RunError, match="another process is running"):
        run_scene(load(scene_file), out, force=True, quiet=True)
    first.kill()
    end(first)
    run_scene(load(scene_file), out, force=True, quiet=True)
    assert len(frames(out)) == 9


def test_telling_frame():
    """The picture is taken a fifth of the rest after half of the loss; without any loss in the middle."""

    def rows(*energies):
        return [
            {"frame": str(k), "kinetic": str(e), "elastic": "0", "potential": "1"}
            for k, e in enumerate(energies)
        ]

    assert telling_frame(rows(10, 10, 9, 3, 2, 2)) == 3
    assert telling_frame(rows(10, 10, 10, 10, 10)) == 2
    assert telling_frame(rows(1, 5, 4, 8, 7, 11, 10, 9)) == 4
    assert telling_frame(rows(3)) == 0
    assert telling_frame(rows(9, "", 1, 0, 0)) == 2  # unknown energy: the middle
    assert telling_frame(rows(*[10] * 3, *[1] * 17)) == 3 + 16 // 5
