"""`neve film`: the film of a run that is there, seen otherwise; and the moment that its picture shows."""

import numpy as np
import pytest
from test_cameras import MOVING

from neve.cli import main
from neve.io.errors import RunError
from neve.io.frames import make_frame
from neve.render.shot import Shot
from neve.run import run
from neve.run.best import COLUMNS, ROWS, best_frame, cells
from neve.run.film import film_run
from neve.scene.reading.load import load
from neve.scene.schema.scene import Camera

NAMES = ("preview.mp4", "preview.png")


@pytest.mark.parametrize("camera", [*MOVING.values(), ["camera.position=[3,-4,2]", "light.sun_elevation=60"]])
def test_film_of_another_camera_is_that_of_a_run_with_it(fake, scene_file, tmp_path, camera):
    """Film and picture have the bytes of a run that had this camera from its start; all else stays."""
    wanted, out = tmp_path / "wanted", tmp_path / "run"
    run(fake.Simulation(load(scene_file, camera)), wanted, quiet=True)
    run(fake.Simulation(load(scene_file)), out, quiet=True)
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    with pytest.raises(SystemExit) as stop:
        main(["film", str(out), "--quiet", *(word for change in camera for word in ("--set", change))])
    assert stop.value.code == 0
    after = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert {path.name for path in after if after[path] != before[path]} == {*NAMES}
    assert after.keys() == before.keys()
    assert [(out / name).read_bytes() for name in NAMES] == [(wanted / name).read_bytes() for name in NAMES]


def test_film_elsewhere_leaves_the_run_as_it_is(fake, scene_file, tmp_path):
    """With --out only that file is new, of the frames and the size that were asked for."""
    out, film = tmp_path / "run", tmp_path / "close.mp4"
    run(fake.Simulation(load(scene_file, ["run.film=false"])), out, quiet=True)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    film_run(out, ["camera.fov=10"], film, slice(2, 7, 2), size=(32, 18))
    after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert after.keys() - before.keys() == {film}
    assert all(after[path] == before[path] for path in before)


def test_what_cannot_be_filmed_is_told(fake, scene_file, tmp_path):
    """Another key than camera and light, another ending, no run, a frame that the run does not have."""
    out = tmp_path / "run"
    run(fake.Simulation(load(scene_file)), out, quiet=True)
    for told, call in {
        r"snow\.xi=3: .* its camera and light alone": lambda: film_run(out, ["snow.xi=3"]),
        r"ends in \.mp4": lambda: film_run(out, out="film.avi"),
        "holds no Neve run": lambda: film_run(tmp_path),
        "none of those asked for": lambda: film_run(out, frames=slice(20, 30)),
    }.items():
        with pytest.raises(RunError, match=told):
            call()


def moments(*shapes, speeds):
    """Frames of 400 particles: widths [m] of a flat cloud in front of the camera, and their speeds [m/s]."""
    grid = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 20), [0], np.linspace(-0.5, 0.5, 20)), -1)
    x = grid.reshape(-1, 3)
    for k, (width, speed) in enumerate(zip(shapes, speeds, strict=True)):
        v = np.full_like(x, speed)
        yield make_frame(x * width, v, None, np.arange(len(x)), None, [], k / 10)


@pytest.mark.parametrize(
    ("widths", "speeds", "best"),
    [
        ([1, 1, 2, 3, 3], [5, 5, 4, 2, 0], 3),  # it flies, bursts, and lies still
        ([1, 1, 1, 1], [5, 5, 5, 5], None),  # it flies on
        ([1, 2, 3, 9], [1, 1, 1, 0.01], 2),  # what creeps does not count
        ([1, 2, 100, 3], [1, 1, 1, 1], 3),  # what has left the picture does not count
        ([1, 2, 3], [0, 0, 0], None),
    ],
)
def test_best_frame_has_the_widest_spread_of_moving_snow(widths, speeds, best):
    """By its definition: cells covered by moving snow, over those that the same snow covered at the start."""
    frames = list(moments(*widths, speeds=speeds))
    shot = Shot(Camera(position=(0, -10, 0), target=(0, 0, 0), fov=40))
    assert best_frame(range(len(frames)), frames.__getitem__, shot) == best


def test_cells_are_those_of_the_picture():
    """The middle, the corners, and what is beyond them or behind, of a picture of 16:9."""
    tall = 10 * np.tan(np.radians(20))
    view = Shot(Camera(position=(0, -10, 0), target=(0, 0, 0), fov=40)).at(0.0)
    corner = np.array([tall * 16 / 9, 0, tall])
    x = np.array([[0, 0, 0], 0.999 * corner, -0.999 * corner, 1.001 * corner, [0, -20, 0]])
    middle = ROWS // 2 * COLUMNS + COLUMNS // 2
    assert list(cells(x, view)) == [middle, ROWS * COLUMNS - 1, 0, -1, -1]
