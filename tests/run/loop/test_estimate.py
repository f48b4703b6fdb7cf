"""What `neve estimate` foresees, against the run itself."""

import json

import numpy as np
import pytest

from neve.cli import main
from neve.cli.estimate import as_text
from neve.run import run_scene
from neve.run.estimate import Estimate, Range, estimate, guess, trial
from neve.run.estimate.trial import Trial, likeness
from neve.scene.errors import SceneError
from neve.scene.reading.load import load

SCENE = """
[numerics]
dx = 0.1
[run]
duration = 0.3
fps = 20
film = false
[[sources]]
shape = "sphere"
radius = 0.3
center = [0, 0, 0.45]
velocity = [0, 0, -3]
[[colliders]]
shape = "plane"
"""
CHANGES = {
    "finer": ["numerics.dx=0.08"],
    "fields, a fixed step": ['run.fields=["tau", "F_E"]', "numerics.transfer=polypic", "numerics.dt=5e-4"],
    "chunks, doubles, sparse frames": [
        'sources.0.structure="chunks"',
        "numerics.precision=float64",
        'outputs=[{kind="frames", every_frames=4}]',
    ],
    "partly inside": ["sources.0.center=[0, 0, 0]", "sources.0.velocity=[0, 0, 0]"],
}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


@pytest.mark.filterwarnings("ignore::neve.scene.errors.SceneWarning")
@pytest.mark.parametrize("name", CHANGES)
def test_a_run_is_as_foreseen(file, tmp_path, name):
    """Particles are exact where the scene itself is filled; disk within 3 %; steps within the stated band."""
    scene = load(file, CHANGES[name])
    found = estimate(scene, seconds=3600.0)
    sim = run_scene(scene, tmp_path / "run", quiet=True)
    disk = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*") if path.is_file())
    picture = (tmp_path / "run/preview.png").stat().st_size
    assert found.particles == (sim.count,) * 3
    assert found.disk - 0.9e6 == pytest.approx(disk - picture, rel=0.03)
    assert found.frame_bytes == pytest.approx((tmp_path / "run/frames/000000.npz").stat().st_size, rel=0.01)
    assert found.frames == 6
    assert found.tried == 1.0
    assert found.steps.low <= sim.steps <= found.steps.high
    assert found.steps.high < 2.0 * found.steps.low
    assert found.seconds.low < found.seconds.likely < found.seconds.high


def test_large_scenes_are_scaled_from_a_coarser_grid(file, tmp_path, monkeypatch):
    """Beyond what is filled, the count is k^3 times that of k dx, and stated as uncertain."""
    scene = load(file, ["numerics.dx=0.04"])
    exact = estimate(scene, 2, seconds=0.1)
    monkeypatch.setattr("neve.run.estimate.foresee.MOST_FILLED", 6000)
    scaled = estimate(scene, 2, seconds=0.1)
    assert scaled.particles.low < exact.particles.likely < scaled.particles.high
    assert scaled.particles.likely == pytest.approx(exact.particles.likely, rel=0.03)
    assert scaled.disk == pytest.approx(exact.disk, rel=0.03)
    quick = guess(load(file, ["numerics.dx=0.02", "run.duration=5"]))
    assert quick.particles.likely == pytest.approx(0.036 * np.pi / 0.02**3 * 8, rel=0.05)


def test_a_likeness_has_longer_steps_in_proportion(file):
    """With k dx, a given step and the largest step are k times as long; nothing else changes."""
    scene = load(file, ["numerics.dt=1e-4", "numerics.dt_max=1e-3"])
    coarse = likeness(scene, 3.0)
    assert (coarse.numerics.dx, coarse.numerics.dt, coarse.numerics.dt_max) == pytest.approx(
        (0.3, 3e-4, 3e-3)
    )
    assert coarse.model_copy(update={"numerics": scene.numerics}) == scene


def test_steps_are_counted_by_frames():
    """A frame is a whole number of steps; after the trial its last third goes on."""

    def of(times, dt):
        return Trial(2.0, 1, np.array(times), np.array(dt), 1.0, 1e-7, 1.0, 1.0)

    assert of([1.0], [0.25]).steps(1, 1) == 4
    assert of([1.0], [0.3]).steps(2, 2) == 4  # 1.67 steps in each half
    assert of([1.0], [5.0]).steps(3, 3) == 3
    assert of([1.0, 2.0, 3.0], [0.5, 0.5, 0.1]).steps(5, 1) == 2 + 2 + 10 + 10 + 10


def test_a_trial_meets_sources_too_small_for_it(file):
    """Snow that a coarse grid cannot hold is tried on a finer one; what cannot be run at all is told."""
    tiny = load(file, ["sources.0.radius=0.1", "numerics.dx=0.04"])
    assert 1.0 <= trial.trial(tiny, 8.0, 0.1, 5.0, None).coarser < 8.0
    with pytest.raises(SceneError, match=r"sources\.0"):
        estimate(load(file, ["sources.0.center=[0, 0, -5]"]), 1, seconds=0.1)


def test_command_says_it_in_json(file, capsys):
    """Whole numbers of particles, steps and bytes; what is not counted is named."""
    arguments = ["estimate", str(file), "--frames", "1", "--set", 'outputs=[{kind="export", to="vtk"}]']
    with pytest.raises(SystemExit) as stop:
        main([*arguments, "--json"])
    assert stop.value.code == 0
    found = json.loads(capsys.readouterr().out)
    assert found["not_counted"] == ["export"]
    assert found["disk_bytes"] > 2 * found["frame_bytes"] > 0
    assert found["particles"]["likely"] == found["particles"]["high"] > 500
    assert isinstance(found["steps"]["low"], int)


def test_command_says_it_in_lines(file):
    """One line for each thing, with how sure it is, and what is not counted or not enough."""
    some = Range(123456.7, 1e5, 2e5)
    found = Estimate(Range(907, 907, 907), 6, some, Range(90, 60, 7200), 1e9, 1e18, 3e7, ("usd",), 2, 0.5, 9)
    lines = dict(line.split(maxsplit=1) for line in as_text(found, load(file)))
    assert list(lines) == ["particles", "frames", "steps", "time", "memory", "disk"]
    assert lines["particles"] == "907, with numerics.dx = 0.1"
    assert lines["steps"].startswith("about 123,000, from 100,000 to 200,000: ")
    assert "ran through 50% of it" in lines["steps"]
    assert lines["time"] == "about 1:30 min, 1:00 min to 2:00 h on 2 threads of this machine, besides usd"
    assert lines["disk"].startswith("1e+09 GB, 30 MB a frame, besides usd; ")
    assert lines["disk"].endswith("are free, which is not enough")


def test_a_long_run_says_so_first(file, capsys, tmp_path, monkeypatch):
    """`neve run` says in one line what takes over a minute, and nothing of what does not."""
    monkeypatch.setattr("neve.run.run_scene", lambda *args, **kwargs: None)
    long = ["--set", "run.duration=3000"]
    for more, times in ([], 0), ([*long, "--frames", "1"], 0), ([*long, "--quiet"], 0), (long, 1):
        with pytest.raises(SystemExit):
            main(["run", str(file), "--out", str(tmp_path / "run"), *more])
        said = [line for line in capsys.readouterr().err.splitlines() if "this takes about" in line]
        assert len(said) == times
    assert said[0].endswith("a frame; neve estimate says more")
