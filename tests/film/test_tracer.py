"""Paths of light against what is known of them: camera, sun, what stands before the snow, what is snow."""

import math

import numpy as np
import pytest

pytest.importorskip("mitsuba", reason="pip install 'neve[film]'")

from neve.build import solids as solids_of
from neve.geometry.pose import Pose
from neve.render.path_tracing.daylight import emitters, sky_toward
from neve.render.path_tracing.engine import mitsuba
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.picture import Choices, PathTracer
from neve.render.path_tracing.tracer import finite
from neve.render.shot import opening
from neve.scene.schema.scene import Body, Camera, Collider, Light, Numerics, Scene, Source

CAMERA = Camera(position=(1.5, -4.0, 1.2), target=(0.3, 0.2, 0.6), fov=34)
FILM = {"type": "hdrfilm", "width": 96, "height": 64, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
LENS = Lens(CAMERA, 96, 64)


def drawn(lens, parts, integrator):
    """A picture of Mitsuba."""
    mi = mitsuba()
    scene = {"type": "scene", "sensor": lens.sensor(mi, FILM, 16, 0), "integrator": integrator, **parts}
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


def layers_of(snow, choices):
    """Layers of snow, a board before its left half and a white ball on its right."""
    scene = Scene(
        sources=(Source.of("box", center=(0.0, 0.0, 0.6), size=(0.8, 0.8, 0.8)),),
        colliders=(Collider.of("box", center=(-0.5, -0.8, 0.6), size=(0.8, 0.02, 1.6)),),
        bodies=(Body.of("sphere", center=(0.9, -0.4, 0.6), radius=0.3, color=(0.95, 0.95, 0.95)),),
        numerics=Numerics(dx=0.1),
        camera=Camera(position=(0.0, -4.0, 0.6), target=(0.0, 0.0, 0.6), fov=30),
    )
    id = np.arange(len(snow))
    view = opening(scene.camera)
    tracer = PathTracer(scene, choices, id, snow, len(snow), [view])
    placed = [(s, Pose.at_rest(p, np.eye(3))) for s, p in zip(solids_of(scene), PLACES, strict=True)]
    lens = Lens(view, 96, 64)
    return tracer._layers(snow.astype(np.float32), id, placed, lens, 1), lens


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
