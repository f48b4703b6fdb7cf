"""From light to a picture, on layers made up here: exposure, sparks, glints, the denoiser."""

import importlib.util

import numpy as np
import pytest

from neve.render.path_tracing.daylight import exposure
from neve.render.path_tracing.develop import SHADE, SPARK, denoised, develop
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.looks import KINDS
from neve.render.path_tracing.snow import Flakes
from neve.render.path_tracing.tracer import Layers
from neve.scene.schema.scene import Camera, Light

SIZE = 64
LIGHT = Light()
LENS = Lens(Camera(position=(0.0, -4.0, 0.0), target=(0.0, 0.0, 0.0), fov=30), SIZE, SIZE)


def light_that_shows(levels):
    """Light (h, w, 3) that is exposed to these levels (h, w), 1 is white."""
    scale, balance = exposure(LIGHT)
    return (np.asarray(levels)[..., None] / (scale * balance)).astype(np.float32)


def shown(layers, sparkle=False):
    """The picture of a volume."""
    kind = KINDS["fresh" if sparkle else "blue_hour"]
    return develop(layers, LENS, LIGHT, LIGHT, kind, 0.05, clean=False)


def many_flakes(y=0.0):
    """Flakes all over the picture, in a plane across the view."""
    x, z = np.random.default_rng(3).uniform(-1.0, 1.0, (2, 400_000))
    centres = np.stack([x, np.full_like(x, y), z], axis=1).astype(np.float32)
    return Flakes(centres, np.full(len(x), 1e-3, np.float32), np.arange(len(x), dtype=np.uint32))


def test_light_is_exposed_and_nothing_else():
    """Without snow, glints and denoiser a picture is its light times the exposure."""
    levels = np.random.default_rng(1).uniform(0.0, 1.0, (SIZE, SIZE))
    found = shown(Layers(light_that_shows(levels)))
    assert found == pytest.approx(np.repeat(levels[..., None], 3, axis=2), abs=1e-5)


def test_glints_stay_out_of_shadow_and_never_darken():
    """In light some pixels are brighter and none darker; below SHADE every pixel is as it was."""
    levels = np.full((SIZE, SIZE), 0.6)
    levels[:, : SIZE // 2] = 0.8 * SHADE
    without, dark, lit = Layers(light_that_shows(levels)), slice(0, SIZE // 2), slice(SIZE // 2, None)
    found = shown(Layers(without.sun, flakes=many_flakes()), sparkle=True)
    before = shown(without)
    assert np.array_equal(found[:, dark], before[:, dark])
    assert found[:, lit].min() >= before[:, lit].min()
    assert 3 < np.sum(found[:, lit, 1] > before[:, lit, 1] + 0.02) < 0.2 * SIZE * SIZE


@pytest.mark.parametrize(("y", "glints"), [(0.0, True), (0.5, False)])
def test_glints_do_not_show_through_what_stands_before_them(y, glints):
    """Flakes at the depth that is seen glint, those behind it do not."""
    column, row = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    across = np.hypot(column - 0.5 * SIZE, row - 0.5 * SIZE) / LENS.focal
    depth = (4.0 * np.hypot(1.0, across)).astype(np.float32)  # of the plane y = 0
    light = light_that_shows(np.full((SIZE, SIZE), 0.6))
    found = shown(Layers(light, depth=depth, flakes=many_flakes(y)), sparkle=True)
    assert bool(found.max() > 0.65) is glints


def test_little_snow_before_dark_ground_is_as_bright_as_much():
    """Ten white pixels of 4096 keep their light; a spark among them is at most SPARK times white."""
    levels = np.full((SIZE, SIZE), 0.01)
    levels[5, :10] = 1.0
    levels[30, 30] = 400.0
    found = shown(Layers(light_that_shows(levels)))
    assert found[5, :10] == pytest.approx(np.ones((10, 3)), rel=1e-4)
    _, balance = exposure(LIGHT)
    assert found[30, 30].max() <= SPARK * balance.max() / balance.min() * (1 + 1e-4)


def test_only_snow_lets_light_spread():
    """A bright pixel on snow shares its light, the same on a white body does not."""
    levels = np.full((SIZE, SIZE), 0.3)
    levels[32, [16, 48]] = 1.2
    half, flat = 0.5 * light_that_shows(levels), np.full((SIZE, SIZE), 4.0, np.float32)
    snow = np.zeros((SIZE, SIZE), np.float32)
    snow[:, : SIZE // 2] = 1.0
    white = np.full((SIZE, SIZE, 3), 0.95, np.float32)
    found = shown(Layers(half, half, white, white, flat, snow))
    assert found[32, 16].max() < 0.7 * found[32, 48].max()
    assert found[32, 47] == pytest.approx(found[10, 47], rel=1e-5)


@pytest.mark.skipif(
    importlib.util.find_spec("mitsuba_oidn") is None, reason="pip install mitsuba mitsuba-oidn"
)
def test_the_denoiser_takes_noise_and_leaves_light():
    """Grey with noise becomes grey with less than a third of it; an edge between two greys stays."""
    rng = np.random.default_rng(4)
    image = np.full((SIZE, SIZE, 3), 0.2, np.float32)
    image[:, SIZE // 2 :] = 0.8
    noisy = (image * rng.gamma(8.0, 1.0 / 8.0, image.shape)).astype(np.float32)
    found = denoised(noisy)
    left, right = found[:, 4 : SIZE // 2 - 4], found[:, SIZE // 2 + 4 : -4]
    assert left.mean() == pytest.approx(0.2, rel=0.05)
    assert right.mean() == pytest.approx(0.8, rel=0.05)
    assert left.std() < noisy[:, 4 : SIZE // 2 - 4].std() / 3


def test_what_happens_far_away_changes_nothing_here():
    """White snow that comes into the right of a dark picture leaves its left as it was, to the bit, and with
    the denoiser, which looks some pixels far, to a grey level."""
    levels = np.full((SIZE, 4 * SIZE), 0.05) * np.random.default_rng(2).gamma(8.0, 1 / 8, (SIZE, 4 * SIZE))
    white = levels.copy()
    white[:, 3 * SIZE :] += 3.0
    lens = Lens(LENS.camera, 4 * SIZE, SIZE)

    def left(picture, clean):
        layers = Layers(light_that_shows(picture))
        return develop(layers, lens, LIGHT, LIGHT, KINDS["blue_hour"], 0.05, clean)[:, :SIZE]

    assert np.array_equal(left(levels, False), left(white, False))
    if importlib.util.find_spec("mitsuba_oidn") is not None:
        assert np.abs(left(levels, True) - left(white, True)).max() < 1 / 255
