"""Motion blur: how long a smear is, and what smears."""

import importlib.util

import numpy as np
import pytest

from neve.film.render import between
from neve.geometry.pose import Pose, rotation_matrix
from neve.io.frames import Frame
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.picture import Choices, PathTracer
from neve.render.path_tracing.shutter import Motion, exposures, smear, velocities
from neve.render.path_tracing.snow import lumps, snow_geometry
from neve.render.shot import View
from neve.scene.schema.scene import Numerics, Scene, Source

needs_mitsuba = pytest.mark.skipif(
    importlib.util.find_spec("mitsuba") is None, reason="pip install mitsuba mitsuba-oidn"
)
DX = 0.1
SIZE = (160, 32)
OPEN = 0.02
"""How long the shutter is open [s]."""


def seen_from(x):
    """A view across y, whose middle lies at x."""
    return View((x, -5.0, 0.0), (x, 0.0, 0.0), (0.0, 0.0, 1.0), 16.0)


def blob(radius=0.2):
    axis = np.arange(-radius, radius + 1e-9, DX / 2)
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    return x[np.linalg.norm(x, axis=1) <= radius].astype(np.float32)


def covered(v, pan=0.0, samples=16):
    """Share of snow in each column of a blurred picture of a blob that moves at v and a camera at `pan` along
    x [m/s]; and how many exposures there were."""
    scene = Scene(sources=(Source.of("sphere"),), numerics=Numerics(dx=DX))
    x, choices = blob(), Choices("draft", "diffuse", samples=samples, size=SIZE)
    id, speed = np.arange(len(x)), np.tile(np.float32([v, 0, 0]), (len(x), 1))
    tracer = PathTracer(scene, choices, id, x, len(x), [seen_from(0.0)])
    seen = lambda dt: ([], Lens(seen_from(pan * dt), *SIZE))  # noqa: E731
    times = exposures(x, speed, seen, OPEN, samples)
    layers = tracer._blurred(x, speed, id, seen, OPEN, times, None)
    return layers.snow.sum(axis=0), len(times)


def spread(columns):
    """The variance of a distribution over columns."""
    at = np.arange(len(columns)) + 0.5
    middle = (columns * at).sum() / columns.sum()
    return (columns * (at - middle) ** 2).sum() / columns.sum()


@needs_mitsuba
def test_a_smear_is_as_long_as_speed_times_shutter_time():
    """Of a dot that is spread evenly over a length L the variance grows by L^2 / 12, and for n exposures in
    the middles of equal parts by (1 - 1 / n^2) of that; L = 100 m/s times 0.02 s is 45.5 pixels."""
    still, one = covered(0.0)
    moving, count = covered(100.0)
    pixels = 100.0 * OPEN * Lens(seen_from(0.0), *SIZE).focal / 5.0
    assert (one, count) == (1, 16)
    assert pixels == pytest.approx(45.5, abs=0.1)
    length = np.sqrt(12.0 * (spread(moving) - spread(still)) / (1.0 - 1.0 / count**2))
    assert length == pytest.approx(pixels, rel=0.02)
    assert moving.sum() == pytest.approx(still.sum(), rel=0.08)  # three deviations of the paths' noise


@needs_mitsuba
def test_a_camera_that_goes_along_sees_it_sharp():
    """What moves as the camera does is not smeared, and what rests is, as long."""
    still, _ = covered(0.0)
    along, count = covered(100.0, pan=100.0)
    passed, _ = covered(0.0, pan=100.0)
    assert count == 16  # for what rests around it
    assert spread(along) == pytest.approx(spread(still), rel=0.08)
    assert spread(passed) > 5 * spread(still)


def test_as_many_exposures_as_the_image_moves():
    """One for what hardly moves or is out of sight, one for each two pixels else, and never too many."""
    x, lens = blob(), Lens(seen_from(0.0), *SIZE)
    rate = 5.0 / lens.focal / OPEN  # m/s for a pixel

    def count(v, where=0.0):
        speed = np.tile([v, 0.0, 0.0], (len(x), 1))
        return len(exposures(x + np.array([0, where, 0]), speed, lambda dt: ([], lens), OPEN, 12))

    assert [count(v * rate) for v in (0.0, 0.3, 5.0, 11.0, 100.0)] == [1, 1, 3, 6, 12]
    assert count(100.0 * rate, where=-9.0) == 1
    speed = np.tile([9 * rate, 0.0, 0.0], (len(x), 1))
    times = exposures(x, speed, lambda dt: ([], lens), OPEN, 12)
    np.testing.assert_allclose(times, OPEN * (np.arange(5) - 2) / 5, atol=1e-12)
    moved = smear(lens, lens, np.zeros((1, 3)), np.array([[0.5, 0.0, 0.0]]))
    assert moved[0] == pytest.approx(0.5 * lens.focal / 5.0)


def test_snow_is_moved_at_its_own_velocity():
    """Within v = A x, which turns and shears, places move with it; a blob that flies moves as a whole."""
    x, A = blob(0.4).astype(np.float64), np.array([[0.1, -2.0, 0.0], [2.0, 0.0, 0.5], [0.0, 0.0, -0.3]])
    places = 0.6 * x
    np.testing.assert_allclose(velocities(places, x, x @ A.T, DX / 2), places @ A.T, atol=0.03)
    id = np.arange(len(x))
    snow = snow_geometry(x.astype(np.float32), id, lumps(x, DX / 2), DX / 2, 8, 0.9, 0.4)
    flown = Motion(snow, x, np.tile([3.0, 0.0, -1.0], (len(x), 1)), DX / 2).after(0.1)
    for before, after in (
        (snow.surface.vertices, flown.surface.vertices),
        (snow.flakes.centres, flown.flakes.centres),
    ):
        np.testing.assert_allclose(after - before, np.tile([0.3, 0.0, -0.1], (len(before), 1)), atol=1e-5)


def test_solids_move_evenly_between_frames():
    """A third of the way to the next frame a solid has gone a third of it and turned by a third."""
    none = np.zeros((0, 3), np.float32)

    def frame(x, angle):
        R = rotation_matrix(np.array([0.0, 0.0, angle]))[None].astype(np.float32)
        place = np.array([[x, 0.0, 1.0]], np.float32)
        return Frame(none, none, None, np.zeros(0, int), None, place, R, 0.0)

    position, rotation = between(frame(0.0, 0.0), frame(3.0, 0.9), 1.0 / 3.0)
    pose = Pose.at_rest(position[0], rotation[0])
    np.testing.assert_allclose(pose.position, (1.0, 0.0, 1.0), atol=1e-6)
    np.testing.assert_allclose(pose.rotation, rotation_matrix(np.array([0.0, 0.0, 0.3])), atol=1e-6)
