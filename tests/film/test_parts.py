"""Parts of a path-traced picture that need no Mitsuba: camera, sky, flakes, textures, ground, tone."""

import math

import numpy as np
import pytest

from neve import _render
from neve.render.lighting import sky_color
from neve.render.path_tracing.daylight import sky_toward
from neve.render.path_tracing.develop import coded, spread
from neve.render.path_tracing.ground import relief, surface_normals
from neve.render.path_tracing.lens import Lens
from neve.render.path_tracing.picture import Choices
from neve.render.path_tracing.snow import grain_count, lumps, snow_geometry
from neve.render.path_tracing.textures import fractal, tile
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Camera, Light
from neve.simulation import Simulation

RNG = np.random.default_rng(6)


def test_lens_projects_as_the_preview_does():
    """Points fall on the same pixels and depths as in the preview's camera."""
    camera = Camera(position=(2.0, -5.0, 1.5), target=(0.2, 0.1, 0.6), fov=37)
    lens = Lens(camera, 320, 180)
    other = _render.Camera(camera.position, camera.target, camera.up, camera.fov, 320, 180)
    for x in RNG.normal(size=(20, 3)):
        column, row, depth = lens.project(x[None])
        assert (column[0], row[0], depth[0]) == pytest.approx(other.project(tuple(x)), abs=2e-3)


@pytest.mark.parametrize(
    "light", [Light(), Light(sun_elevation=5, sky_strength=2.0, sky_color=(1, 0.5, 0.2))]
)
def test_sky_lights_level_ground_as_the_scene_says(light):
    """The integral of L cos over the upper half is pi times the sky's colour (uniform in cos^2 and angle)."""
    z, turn = (np.sqrt((np.arange(64) + 0.5) / 64), 2 * np.pi * (np.arange(128) + 0.5) / 128)
    z, turn = (a.ravel() for a in np.meshgrid(z, turn, indexing="ij"))
    flat = np.sqrt(1 - z * z)
    directions = np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
    found = math.pi * sky_toward(light, directions).mean(axis=0)
    assert found == pytest.approx(math.pi * np.array(sky_color(light)), rel=0.01)


def test_flakes_go_with_their_particles():
    """In snow that moves as a whole (by cells of its fields) flakes are the same ones, moved."""
    h = 0.1
    x = (np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), -1).reshape(-1, 3) * h).astype(np.float32)
    id = np.arange(len(x))
    here = snow_geometry(x, id, lumps(x, h), h, 8, 0.98, 0.4).flakes
    there = snow_geometry(x + np.float32(0.8), id, lumps(x, h), h, 8, 0.98, 0.4).flakes
    common, a, b = np.intersect1d(here.names, there.names, return_indices=True)
    assert len(common) > 0.98 * len(here.names) > 100
    assert np.abs(there.centres[b] - here.centres[a] - 0.8).max() < 1e-4
    vertices, faces = here.triangles()
    far = np.linalg.norm(vertices.reshape(-1, 4, 3) - here.centres[:, None], axis=2)
    assert far == pytest.approx(np.repeat(here.radii[:, None], 4, axis=1), rel=1e-3)
    assert faces.max() == len(vertices) - 1


def test_packed_particles_have_one_smooth_surface():
    """The upper side of a slab of particles in contact, packed as by a run, is rough by less than 0.3 of
    their spacing, lumps and all; one found 0.25, and 0.20 of the material point method's particles."""
    numerics, ground = {"method": "particles", "dx": 0.1}, {"shape": "plane"}
    slab = {"shape": "box", "center": [0.0, 0.0, 0.25], "size": [1.6, 1.6, 0.5]}
    scene = scene_from({"numerics": numerics, "sources": [slab], "colliders": [ground]})
    x, h = np.asarray(Simulation(scene, threads=1).state.x, np.float32), scene.numerics.spacing
    found = snow_geometry(x, np.arange(len(x)), lumps(x, h), h, 27, 0.0, 0.4).surface.vertices

    inner = found[np.abs(found[:, :2]).max(axis=1) < 0.5]
    cell, n = np.floor((inner[:, :2] + 0.5) / h).astype(int), int(1 / h)
    top = np.full(n * n, -np.inf)
    np.maximum.at(top, cell @ [n, 1], inner[:, 2])
    assert top.min() > 0.4
    assert top.std() < 0.3 * h


def test_a_grain_is_about_a_pixel_and_there_are_not_too_many():
    """k = (s / (across pixel))^3, at least 1, at most 125 and what may be drawn in all."""
    assert grain_count(0.04, 0.01, 1000, 10**9, 1.0) == 64
    assert grain_count(0.001, 0.01, 1000, 10**9, 1.0) == 1
    assert grain_count(1.0, 0.01, 1000, 10**9, 1.0) == 125
    assert grain_count(0.04, 0.01, 1000, 8000, 1.0) == 8


def test_tiles_have_no_seam():
    """A texture goes on at its other side as it does within: no step is larger at the seam than elsewhere."""
    found = tile(128, 4, 4, 0.6, 3)
    for image in (found, found.T):
        inside = np.abs(np.diff(image, axis=0)).max()
        assert np.abs(image[0] - image[-1]).max() <= inside
    assert found.std() > 0.1


def test_noise_fades_before_it_aliases():
    """Octaves smaller than two pixels are gone: noise seen from far away is flat."""
    u, v = RNG.uniform(-5, 5, (2, 500))
    assert np.abs(fractal(u, v, 0.1, 5, 0.5, 1.0, 0)).max() == 0.0
    assert fractal(u, v, 0.1, 5, 0.5, 0.001, 0).std() > 0.2


def test_ground_lies_below_the_snow_but_for_stones():
    """The relief keeps below the plane, but for stones, which stand out by at most a third of a cell."""
    dx = 0.05
    u, v = RNG.uniform(-3, 3, (2, 4000))
    height, color = relief(u, v, np.full(4000, 0.002), dx)
    assert height.max() <= 0.36 * dx
    assert np.mean(height > 0) < 0.2
    assert 0.0 < color.min() < color.max() <= 0.8


def test_normals_of_the_ground_are_those_of_the_surface_and_face_the_eye():
    """On rings around the eye; a slope that the eye cannot see has none that faces away."""
    radius, angle = np.geomspace(1.0, 1.5, 60)[:, None], np.linspace(0.0, 2 * np.pi, 241)[None, :]
    u, v, eye = radius * np.cos(angle), radius * np.sin(angle), np.array([0.0, 0.0, 2.0])
    want = np.stack([-0.4 * u, -0.4 * v, np.ones_like(u)], -1)
    want /= np.linalg.norm(want, axis=-1, keepdims=True)
    inner = slice(1, -1)  # differences are one-sided on the first and the last ring
    got = surface_normals(np.stack([u, v, 0.2 * (u**2 + v**2)], -1), eye)
    np.testing.assert_allclose(got[inner], want[inner], atol=2e-3)
    hidden = np.stack([u, v, -3.0 * (u**2 + v**2)], -1)
    view = eye - hidden
    view /= np.linalg.norm(view, axis=-1, keepdims=True)
    assert (surface_normals(hidden, eye) * view).sum(-1).min() > 0.0


def test_light_spreads_in_snow_alone():
    """Even light stays even; a spark on snow spreads and keeps to the snow; pixels without snow stay as they
    are."""
    flat = np.full((40, 60, 3), 0.7, np.float32)
    depth, radius = np.full((40, 60), 5.0, np.float32), np.full((40, 60), 4.0, np.float32)
    snow = np.zeros((40, 60), np.float32)
    snow[:, :30] = 1.0
    assert spread(flat, snow, depth, radius, 0.1) == pytest.approx(flat, abs=1e-6)
    spark = flat.copy()
    spark[20, 15] = 30.0
    found = spread(spark, snow, depth, radius, 0.1)
    assert found[20, 15].max() < 15.0
    assert found[18:23, 12:19].sum() > flat[18:23, 12:19].sum() + 1.0
    assert np.array_equal(found[:, 30:], spark[:, 30:])


def test_tone_is_steady_and_never_flat():
    """More light is never darker, black is black, and light of 1.5 times white is not yet 255."""
    light = np.linspace(0, 3, 400, dtype=np.float32)[:, None, None].repeat(3, axis=2)
    shown = coded(light)[:, 0, 1].astype(int)
    assert np.all(np.diff(shown) >= 0)
    assert shown[0] == 0
    assert shown[200] < 253


def test_choices_take_the_place_of_the_quality():
    """What is given counts, the rest is as the quality has it."""
    found = Choices("draft", look="medium", samples=3, size=(10, 20)).all
    assert (found.look, found.samples, found.size) == ("medium", 3, (10, 20))
    assert found.bounces == Choices("draft").all.bounces


def test_terrain_without_a_finish_is_no_coat_of_paint():
    """It is diffuse, without a relief: one that a camera close to the ground would see pixel by pixel."""
    pytest.importorskip("mitsuba", reason="pip install 'neve[film]'")
    from types import SimpleNamespace

    from neve.render.path_tracing.solids import Materials

    def kind(terrain, finish):
        return Materials().of(SimpleNamespace(finish=finish, color=None, terrain=terrain))["bsdf"]["type"]

    assert kind(object(), None) == "diffuse"
    assert kind(object(), "paint") == kind(None, None) == "bumpmap"
