"""Paths of light against what is known of them: camera, sun, what stands before the snow, what is snow."""

import math

import numpy as np
import pytest

pytest.importorskip("mitsuba", reason="pip install mitsuba mitsuba-oidn")

from neve.build import solids as solids_of
from neve.geometry.pose import Pose
from neve.render.lighting import sun_color
from neve.render.path_tracing.daylight import emitters, sky_toward
from neve.render.path_tracing.engine import mitsuba
from neve.render.path_tracing.lens import Lens, sampler
from neve.render.path_tracing.picture import Choices, PathTracer
from neve.render.path_tracing.tracer import finite
from neve.render.shot import opening
from neve.scene.schema.scene import Body, Camera, Collider, Light, Numerics, Scene, Source

CAMERA = Camera(position=(1.5, -4.0, 1.2), target=(0.3, 0.2, 0.6), fov=34)
FILM = {"type": "hdrfilm", "width": 96, "height": 64, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
LENS = Lens(CAMERA, 96, 64)


def drawn(lens, parts, integrator, samples=16):
    """A picture of Mitsuba."""
    mi = mitsuba()
    scene = {"type": "scene", "sensor": lens.sensor(mi, FILM, samples, 0), "integrator": integrator, **parts}
    return finite(mi.render(mi.load_dict(scene), seed=1))


@pytest.mark.parametrize("place", [(0.9, 0.0, 1.0), (-0.6, 0.4, 0.3)])
def test_what_is_traced_is_where_the_lens_projects_it(place):
    """The pixels of a small ball away from the middle lie around the projection of its centre."""
    ball = {"type": "sphere", "center": list(place), "radius": 0.08}
    depth = drawn(LENS, {"ball": ball}, {"type": "aov", "aovs": "dd:depth"})[..., -1]
    row, column = (np.nonzero(depth > 0)[k].mean() + 0.5 for k in (0, 1))
    expected = LENS.project(np.array([place]))
    assert (column, row) == (pytest.approx(expected[0][0], abs=0.5), pytest.approx(expected[1][0], abs=0.5))
    assert abs(column - 48) > 8


@pytest.mark.parametrize("azimuth", [20.0, 200.0])
def test_the_sky_is_brightest_where_the_sun_stands(azimuth):
    """Seen through the camera the sky is what `sky_toward` says, so towards the sun as away from it."""
    light = Light(sun_azimuth=azimuth, sun_elevation=20)
    turn = math.radians(200.0)
    lens = Lens(Camera(position=(0, 0, 0), target=(math.cos(turn), math.sin(turn), 0.6), fov=20), 96, 64)
    seen = drawn(lens, {"sky": emitters(light)["sky"]}, {"type": "path"})[24:40, 40:56].mean(axis=(0, 1))
    assert seen == pytest.approx(sky_toward(light, lens.axes[2][None])[0], rel=0.02)


@pytest.fixture(scope="module")
def snow():
    """Packed snow around (0, 0, 0.6)."""
    h = 0.05
    return np.stack(np.meshgrid(*[np.arange(16)] * 3, indexing="ij"), -1).reshape(-1, 3) * h - [
        0.4,
        0.4,
        -0.2,
    ]


def scene_of():
    """A block of snow, a board before its left half and a white ball on its right."""
    return Scene(
        sources=(Source.of("box", center=(0.0, 0.0, 0.6), size=(0.8, 0.8, 0.8)),),
        colliders=(Collider.of("box", center=(-0.5, -0.8, 0.6), size=(0.8, 0.02, 1.6)),),
        bodies=(Body.of("sphere", center=(0.9, -0.4, 0.6), radius=0.3, color=(0.95, 0.95, 0.95)),),
        numerics=Numerics(dx=0.1),
        camera=Camera(position=(0.0, -4.0, 0.6), target=(0.0, 0.0, 0.6), fov=30),
    )


def placed():
    """The board and the ball where they are."""
    return [(s, Pose.at_rest(p, np.eye(3))) for s, p in zip(solids_of(scene_of()), PLACES, strict=True)]


@pytest.mark.parametrize("size", [0.0, 6.0])
def test_the_edge_of_a_shadow_is_as_wide_as_the_sun(size):
    """Under a half plane at height h the sun overhead lights the ground by the part of its disk that is seen,
    1/2 + (u sqrt(1 - u^2) + asin u) / pi with u = x / (h tan a), a half of its angle; in full as `sun_color`
    says of any size."""
    light, lens = Light(sun_elevation=90, sun_size=size), Lens(BELOW, 96, 64)
    T = mitsuba().ScalarTransform4f
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [1.0] * 3}}
    black = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}}
    parts = {
        "sun": emitters(light)["sun"],
        "ground": {"type": "rectangle", "to_world": T().scale(4), "bsdf": white},
        "roof": {
            "type": "rectangle",
            "to_world": T().translate([-4, 0, 1]).scale(4),
            "bsdf": {"type": "twosided", "bsdf": black},
        },
    }
    image = drawn(lens, parts, {"type": "path", "max_depth": 2}, 200) / np.array(sun_color(light))
    x = np.linspace(-0.12, 0.12, 25)
    column, row, _ = lens.project(np.stack([x, 0 * x, 0 * x], axis=1))
    seen = np.array([image[int(r) - 2 : int(r) + 3, int(q)].mean() for r, q in zip(row, column, strict=True)])
    if not size:
        expected = np.where(x > 0, 1.0, 0.0)
        np.testing.assert_allclose(np.delete(seen, 12), np.delete(expected, 12), atol=0.02)
        return
    u = np.clip(x / math.tan(math.radians(0.5 * size)), -1.0, 1.0)
    np.testing.assert_allclose(seen, 0.5 + (u * np.sqrt(1 - u * u) + np.arcsin(u)) / math.pi, atol=0.06)


BELOW = Camera(position=(0.0, -2.0, 0.6), target=(0.0, 0.0, 0.0), fov=10)


def layers_of(snow, choices):
    """Layers of the scene."""
    id = np.arange(len(snow))
    view = opening(scene_of().camera)
    tracer, lens = PathTracer(scene_of(), choices, id, snow, len(snow), [view]), Lens(view, 96, 64)
    return tracer._layers(snow.astype(np.float32), id, (placed(), lens)), lens


PLACES = np.array([[-0.5, -0.8, 0.6], [0.9, -0.4, 0.6]])


def test_a_volume_tells_the_depth_of_what_stands_before_it(snow):
    """Where the board hides the snow its depth is seen, beside it that of the snow."""
    layers, lens = layers_of(snow, Choices("draft", "medium", samples=1, size=(96, 64)))
    column, row, _ = lens.project(np.array([[-0.3, -0.81, 0.6], [0.15, -0.4, 0.6]]))
    board, front = layers.depth[row.astype(int), column.astype(int)]
    assert board == pytest.approx(math.hypot(3.19, 0.3), rel=0.01)
    assert front == pytest.approx(3.6, rel=0.02)
    assert layers.depth[2, 90] == 0.0


@pytest.mark.parametrize("kind", ["fresh", "wet"])
def test_snow_of_any_kind_is_snow_and_a_white_ball_is_not(snow, kind):
    """The share of snow is 1 within it and 0 on the ball, on the board and in the sky, wet snow or fresh."""
    layers, lens = layers_of(snow, Choices("draft", "diffuse", kind, samples=1, size=(96, 64)))
    places = np.array([[0.15, -0.4, 0.6], [0.9, -0.7, 0.6], [-0.5, -0.81, 0.6]])
    column, row, _ = lens.project(places)
    assert layers.snow[row.astype(int), column.astype(int)].tolist() == [1.0, 0.0, 0.0]
    assert layers.snow[2, 90] == 0.0


def test_still_snow_looks_still(snow):
    """Two frames of the same snow are the same picture, to the bit, and snow that moves five metres away
    changes no more than one pixel in a hundred of what stands still (paths of light that met it)."""
    choices, id = Choices("draft", samples=2, size=(96, 64)), np.arange(len(snow) + 512)
    far = snow[:512] * 0.5 + [3.0, 4.0, 0.0]
    frames = [np.concatenate([snow, far + shift]).astype(np.float32) for shift in (0.0, 0.0, [0.2, 0.1, 0.3])]
    view = opening(scene_of().camera)
    tracer, lens = PathTracer(scene_of(), choices, id, frames[0], len(id), [view]), Lens(view, 96, 64)
    first, same, other = (tracer._layers(x, id, (placed(), lens)) for x in frames)
    for name in ("sun", "sky", "albedo", "normal", "depth", "snow"):
        assert np.array_equal(getattr(first, name), getattr(same, name))
    here = first.snow > 0
    here[:, 80:] = False  # the far snow is seen there
    assert here.sum() > 400
    moved = (np.abs(first.sun - other.sun) + np.abs(first.sky - other.sky)).max(axis=2) > 0
    assert moved[here].mean() < 0.01
    assert moved.any()


def test_noise_stays_while_the_camera_does():
    """The seed is the same for one view and for views that differ by a thousandth of a pixel, and another one
    for a camera that moves by a pixel, turns or zooms."""
    view = Camera(position=(1.0, -4.0, 1.2), target=(0.3, 0.2, 0.6), fov=34)

    def seed(**change):
        return Lens(view.model_copy(update=change), 96, 64).seed

    assert seed(position=(1.0, -4.0 + 1e-9, 1.2)) == seed()
    for change in ({"position": (1.0, -4.01, 1.2)}, {"target": (0.31, 0.2, 0.6)}, {"fov": 34.1}):
        assert seed(**change) != seed()


@pytest.mark.parametrize("samples", [1, 2, 3, 5, 7, 12, 13, 23])
def test_as_many_paths_as_asked_for(samples):
    """No sampler takes more paths than it is told to."""
    assert mitsuba().load_dict(sampler(samples, 0)).sample_count() == samples
