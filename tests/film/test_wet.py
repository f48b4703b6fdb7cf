"""Melt water in path-traced pictures: slush against dry snow, wet earth, drops."""

import numpy as np
import pytest

from neve.build import solids as solids_of
from neve.geometry.pose import Pose
from neve.render.drops import draw_drops
from neve.render.path_tracing.ground import DEPTH, FILLED, WET, relief, wet_relief
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.looks import SLUSH, wet_color
from neve.render.shot import opening
from neve.scene.schema.scene import Camera, Collider, Light, Numerics, Scene, Source

S = 0.05  # spacing of particles [m]
SIZE = (96, 64)
CAMERA = Camera(position=(0.6, -2.6, 0.9), target=(0.0, 0.0, 0.4), fov=30)


def test_wet_snow_is_darker_the_wetter_it_is():
    """Reflectance falls from that of dry snow over SLUSH, at a third, and blue is left more than red."""
    found = wet_color((0.95, 0.965, 0.985), np.linspace(0.0, 1.0, 13))
    assert found[0] == pytest.approx((0.95, 0.965, 0.985))
    assert found[4] == pytest.approx(SLUSH)
    assert (np.diff(found, axis=0) < 0).all()
    assert (found[:, 2] > found[:, 0]).all()


def test_water_fills_hollows_of_the_ground_and_darkens_it():
    """Dry earth stays as it is; the wettest is WET times as bright; water is level where it stands, and what
    stands out of it stays."""
    u, v = np.meshgrid(np.linspace(0, 3, 200), np.linspace(0, 3, 200))
    dx = 0.05
    height, color = relief(u, v, 1e-4, dx)
    for a, b in zip(wet_relief(height, color, 0 * u, dx), (height, color, 0 * u), strict=True):
        assert np.array_equal(a, b)
    high, dark, film = wet_relief(height, color, 1 + 0 * u, dx)
    assert dark == pytest.approx(color * WET)
    assert (high >= height).all()
    stands = film == 1.0
    assert 0.05 < stands.mean() < 0.95
    assert np.ptp(high[stands]) < 1e-3 * DEPTH * dx < np.ptp(height[stands])
    dry = height > DEPTH * dx * (FILLED - 1)
    assert np.array_equal(high[dry], height[dry])
    assert np.ptp(film[dry]) == 0.0


def test_a_drop_is_drawn_where_it_is_and_not_behind_what_is_nearer():
    """Of three drops one is in sight, one behind what is seen there, one behind the camera."""
    lens = Lens(CAMERA, *SIZE)
    drops = np.array([[0.0, 0.0, 0.5], [0.3, 1.0, 0.4], [0.6, -3.6, 0.9]])
    out = np.full((64, 96, 3), 0.5, np.float32)
    depth = np.full((64, 96), 2.9, np.float32)
    draw_drops(out, drops, S, depth, lens, Light(), np.ones(3))
    changed = np.argwhere((out != 0.5).any(axis=2))
    column, row, _ = lens.project(drops[:1])
    assert 0 < len(changed) < 30
    assert np.abs(changed - [row[0] - 0.5, column[0] - 0.5]).max() < 4
    assert np.isfinite(out).all()


@pytest.fixture(scope="module")
def pictures():
    """Tell the light of a block on the ground whose particles have a liquid share."""
    pytest.importorskip("mitsuba", reason="pip install mitsuba mitsuba-oidn")
    from neve.render.path_tracing.picture import Choices, PathTracer

    scene = Scene(
        sources=(Source.of("sphere"),),
        colliders=(Collider.of("plane"),),
        camera=CAMERA,
        light=Light(sun_azimuth=240, sun_elevation=30),
        numerics=Numerics(dx=2 * S),
    )
    x = np.stack(np.meshgrid(*[np.arange(16)] * 3, indexing="ij"), -1).reshape(-1, 3) * S - [0.4, 0.4, -0.1]
    x, id = x.astype(np.float32), np.arange(16**3)
    view, placed = opening(scene.camera), [(solids_of(scene)[0], Pose.at_rest(np.zeros(3), np.eye(3)))]

    def light(water, look="diffuse", speed=0.0, open_for=0.0):
        choices = Choices("draft", look, samples=4, size=SIZE, denoise=False)
        tracer = PathTracer(scene, choices, id, x, len(x), [view])
        share = None if water is None else np.full(len(x), water, np.float32)
        v = np.full_like(x, speed)
        return tracer.draw(x, v, id, lambda dt: (placed, view), open_for, None, share)

    return light


def test_snow_of_which_nothing_is_wet_is_drawn_as_without_heat(pictures):
    """To the bit."""
    assert np.array_equal(pictures(0.0), pictures(None))


@pytest.mark.parametrize("look", ["diffuse", "medium"])
def test_slush_is_darker_than_snow(pictures, look):
    """The block's front, half melted, sends back less light than dry."""
    front = slice(24, 40), slice(38, 58)
    dry, wet = pictures(None, look)[front], pictures(0.5, look)[front]
    assert wet.mean() < 0.95 * dry.mean()


@pytest.mark.parametrize("look", ["diffuse", "medium", "metaballs"])
def test_water_that_stands_together_is_seen_into(pictures, look):
    """A block of water where nothing is snow: its front is dark and blue beside that of snow, as smooth as no
    heap of balls is, and moves while the shutter is open.
    """
    front = slice(28, 38), slice(42, 54)
    snow, water = pictures(None, look), pictures(1.0, look)
    assert np.isfinite(water).all()
    assert water[front].mean() < 0.4 * snow[front].mean()
    assert water[front][..., 2].mean() > water[front][..., 0].mean()
    moved = pictures(1.0, look, speed=1.0, open_for=0.2)
    assert np.abs(moved - water).mean() > 0.02 * water.mean()
