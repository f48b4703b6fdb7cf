"""Light in metaballs: what passes through one, what thick snow hides, and which way it sends light on."""

import math

import numpy as np
import pytest

from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.looks import KINDS, Medium
from neve.render.path_tracing.metaball_light import (
    G,
    _directions,
    _second,
    lit,
    metaballs_before,
    together,
    transmitted,
)
from neve.render.path_tracing.optics import cornette_shanks
from neve.render.path_tracing.tracer import Layers
from neve.scene.schema.scene import Camera, Light
from neve.surface.metaballs import Metaballs, snow_balls

WHITE = (0.985, 0.990, 0.995)
NOON = Light(sun_elevation=90)


def test_light_passes_a_ball_as_its_integral_says():
    """Through the centre of a ball int f ds = 2 R (1 - 22/27 + 17/45 - 4/63) of its strength."""
    radius, strength, extinction = 0.5, 0.8, 3.0
    field = Metaballs(np.zeros((1, 3), np.float32), radius, np.array([strength], np.float32)).field(0.02)
    below = np.array([[0.0, 0.0, -0.7]], np.float32)
    share = transmitted(field, below, np.array([0.0, 0.0, 1.0]), extinction, 0.01, 2.0)
    depth = extinction * strength * 2 * radius * (1 - 22 / 27 + 17 / 45 - 4 / 63)
    assert share == pytest.approx([math.exp(-depth)], rel=0.01)


def test_directions_share_the_upper_half():
    """Solid angles add up to 2 pi, and the integral of the cosine is pi."""
    found = _directions()
    assert sum(angle for _, angle in found) == pytest.approx(2 * math.pi)
    assert sum(angle * direction[2] for direction, angle in found) == pytest.approx(math.pi)


def test_second_scattering_goes_forward():
    """A lit cell sends more light to the cell behind it, away from the sun, than to the one before it, by the
    ratio of the phase function at 0 and 180 degrees; none is below zero."""
    once = np.zeros((7, 7, 7), np.float32)
    once[3, 3, 3] = 1.0
    found = _second(once, np.array([0.0, 0.0, 1.0]), Medium(20.0, WHITE), 0.05)
    ratio = cornette_shanks(1.0, G) / cornette_shanks(-1.0, G)
    assert found[3, 3, 2] / found[3, 3, 4] == pytest.approx(float(ratio), rel=1e-4)
    assert found.min() >= 0.0


def test_sun_is_brighter_on_top_of_snow_than_below():
    """Light falls with the depth below the surface, steadily, and all of it is gone below a thick layer."""
    h = 0.1
    x = np.stack(np.meshgrid(*[np.arange(10)] * 3, indexing="ij"), -1).reshape(-1, 3) * h
    found = lit(snow_balls(x, h), Medium(30.0, WHITE), NOON, np.array([0.0, -5.0, 1.0]))
    middle = tuple(n // 2 for n in found.sun.shape[:2])
    column = found.sun[middle]
    inside = column[3:-3]
    assert np.all(np.diff(inside) > -1e-5)
    assert inside[0] < 2e-3 < 0.5 < column.max()


def test_thick_snow_hides_what_lies_behind():
    """A block of snow before a red wall: red outside its outline, none of it in the middle."""
    h = 0.1
    x = np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), -1).reshape(-1, 3) * h - 0.35
    lens = Lens(Camera(position=(0, -4, 0), target=(0, 0, 0), fov=30), 24, 24)
    red = np.zeros((24, 24, 3), np.float32)
    red[..., 0] = 1.0
    behind = Layers(0 * red, red, red, red, np.full((24, 24), 6.0, np.float32))
    medium = Medium(60.0, WHITE)
    seen = metaballs_before(behind, snow_balls(x, h), medium, NOON, lens).sun
    assert seen[0, 0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    middle = seen[12, 12]
    assert middle[2] > 0.5 * middle[0] > 0.0
    assert metaballs_before(behind, snow_balls(x[:0], h), medium, NOON, lens).sun == pytest.approx(red)


def test_darker_snow_is_darker_as_metaballs():
    """The albedo of the kind of snow counts: each colour of wet snow sends back less than that of fresh."""
    h = 0.1
    x = np.stack(np.meshgrid(*[np.arange(6)] * 3, indexing="ij"), -1).reshape(-1, 3) * h - 0.25
    lens = Lens(Camera(position=(0, -4, 0), target=(0, 0, 0), fov=12), 16, 16)
    dark = np.zeros((16, 16, 3), np.float32)
    behind = Layers(dark, dark, dark, dark, np.full((16, 16), 6.0, np.float32))
    fresh, wet = (
        metaballs_before(behind, snow_balls(x, h), Medium(60.0, KINDS[kind].albedo), NOON, lens).sun[8, 8]
        for kind in ("fresh", "wet")
    )
    assert np.all(wet < fresh)


def test_a_crumb_far_away_does_not_widen_the_box():
    """A lone particle far outside the box of the rest is left out, one near or inside it is not, nor is snow
    of loners."""
    h = 0.1
    x = np.stack(np.meshgrid(*[np.arange(6)] * 3, indexing="ij"), -1).reshape(-1, 3) * h
    both = np.concatenate([x, x + np.array([3.0, 0.0, 0.0]), [[1.5, 0.2, 0.2]]])
    near, far = (np.concatenate([both, [[0.0, 0.0, z]]]) for z in (9.0, 9e4))
    assert np.array_equal(together(near, h), near)
    assert np.array_equal(together(far, h), both)
    assert np.array_equal(together(far[-2:], h), far[-2:])
