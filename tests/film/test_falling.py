"""Flakes in the air: how many, where, how they fall, and what they cover."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from neve.build import placed_at_start
from neve.render.falling import SWAY, draw_falling, flakes_at
from neve.render.path_tracing.lens import Lens
from neve.render.preview import Preview
from neve.scene.reading.load import load
from neve.scene.schema.scene import Camera, Light

LENS = Lens(Camera(position=(0.0, -4.0, 1.0), target=(0.0, 0.0, 1.0), fov=40.0), 160, 90)


def test_as_many_as_stated():
    """100 in a cubic metre: a box of 2 m has 800 within four deviations of a random count."""
    place, _, radius = flakes_at(Light(falling=100.0), LENS, 0.3)
    here = np.all(np.abs(place - LENS.eye) < 1.0, axis=1)
    assert abs(int(here.sum()) - 800) < 4.0 * np.sqrt(800.0)
    assert radius.mean() == pytest.approx(0.004, rel=0.02)


def test_they_fall_as_stated_and_swing():
    """In 0.1 s they go 0.1 v on average, and aside by no more than their swing."""
    light = Light(falling=50.0, flake_velocity=(0.5, 0.0, -1.0))
    a, b, _ = flakes_at(light, LENS, 1.0, 0.1)
    way = b - a
    assert way[:, 2].mean() == pytest.approx(-0.1, rel=0.02)
    assert np.abs(way[:, 0] - 0.05).max() < 2 * SWAY + 0.02
    later, _, _ = flakes_at(light, LENS, 1.1)
    inside = np.all(np.abs(b - LENS.eye) < 2.0, axis=1)
    assert nearest(later, b[inside]).max() < 1e-9


@pytest.mark.parametrize("back", [0.0, 3.0])
def test_the_camera_moves_through_still_flakes(back):
    """Flakes near two places of a camera are the same ones of the world, however far it sees."""
    light = Light(falling=50.0)
    moved = replace(LENS, camera=Camera(position=(0.5, -4.0 - back, 1.2), target=(0.5, 0.0, 1.2), fov=40.0))
    (a, *_), (b, *_) = flakes_at(light, LENS, 0.4), flakes_at(light, moved, 0.4)
    near = np.all(np.abs(a - np.array([0.2, -4.5, 1.0])) < 1.5, axis=1)
    assert near.sum() > 1000
    assert nearest(b, a[near]).max() < 1e-9


def nearest(places, x):
    """How far the nearest of `places` is from each x [m]."""
    return cKDTree(places).query(x)[0]


def drawn(depth, open_for=0.0, **keys):
    """A black picture with flakes."""
    out = np.zeros((90, 160, 3), np.float32)
    light = Light(**{"falling": 20.0, "flake_radius": 0.01, **keys})
    far = np.full((90, 160), depth, np.float32)
    return draw_falling(out, light, (LENS, LENS), 0.5, open_for, far)


def test_what_is_near_hides_them():
    """Before the sky there are flakes; before a wall 0.2 m away none; a nearer wall leaves fewer."""
    sky, wall = drawn(0.0), drawn(2.0)
    assert sky.max() > 0.3
    assert 0.0 < (wall > 0).mean() < (sky > 0).mean()
    assert not drawn(0.2).any()


def test_the_shutter_smears_them():
    """Open for 1/25 s flakes are lines that fall: more pixels, each fainter, as much light to a third."""
    still, smeared = drawn(0.0), drawn(0.0, open_for=0.04)
    assert (smeared > 0).sum() > 1.3 * (still > 0).sum()
    assert smeared.mean() == pytest.approx(still.mean(), rel=0.33)


def test_night_has_dark_flakes():
    """Without sun and sky a flake is black."""
    assert drawn(0.0, sun_strength=0.0, sky_strength=0.0).max() == 0.0


def preview(time=0.4, threads=1, **changes):
    """A preview of a post before the sky, with large flakes."""
    keys = {"falling": 40.0, "flake_radius": 0.02, "flake_velocity": (0.0, 0.0, -1.0), **changes}
    scene = load("porch", [])
    light = scene.light.model_copy(update=keys)
    camera = Camera(position=(0.0, -4.0, 1.0), target=(0.0, 0.0, 1.0), fov=40.0, shutter=0.5)
    scene = scene.model_copy(update={"light": light, "camera": camera})
    return Preview(scene, 160, 90, threads=threads), scene


NONE = np.zeros((0, 3), np.float32)


def test_the_preview_draws_the_same_flakes():
    """Where the path-traced film has flakes before the sky the preview has them; as long; none without."""
    painter, scene = preview()
    still = preview(falling=0.0)[0].draw(NONE, []).astype(int)
    picture = painter.draw(NONE, [], time=0.4).astype(int)
    lens = Lens(scene.camera, 160, 90)
    open_for = 0.5 / scene.run.fps
    black = np.zeros((90, 160, 3), np.float32)
    wanted = draw_falling(black, scene.light, (lens, lens), 0.4, open_for, None).max(axis=2)
    changed = np.abs(picture - still).max(axis=2)
    assert (wanted > 0.3).sum() > 300
    assert (changed[wanted > 0.3] > 4).mean() > 0.95
    assert (changed[wanted == 0.0] <= 1).all()


def test_flakes_of_the_preview_do_not_stay():
    """A painter that has drawn flakes draws the next moment as one that has not; on any number of threads."""
    painter, _ = preview()
    painter.draw(NONE, [], time=0.2)
    again = painter.draw(NONE, [], time=0.4)
    for threads in (1, 2, 3):
        assert np.array_equal(again, preview(threads=threads)[0].draw(NONE, [], time=0.4))


def test_solids_of_the_preview_hide_flakes():
    """A wall 0.6 m before the lens leaves only the flakes before it: fewer than the sky shows."""
    painter, scene = preview()
    wall = next(pair for pair in placed_at_start(scene) if pair[0].shape == "box")
    near = replace(wall[1], position=np.array([0.0, -3.2, 1.0]))

    def shown(solids):
        with_flakes = painter.draw(NONE, solids, time=0.4).astype(int)
        return np.abs(with_flakes - preview(falling=0.0)[0].draw(NONE, solids).astype(int)).max(axis=2) > 8

    sky, wall_ = shown([]), shown([(wall[0], near)])
    assert 0 < wall_.sum() < 0.5 * sky.sum()
