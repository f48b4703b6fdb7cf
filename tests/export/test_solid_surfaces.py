"""Surfaces of solids: closed, seen from outside, of the right volume."""

import math

import numpy as np
import pytest
import trimesh

from neve.build import solids
from neve.colliders.solid import Solid
from neve.colliders.triangles import triangles
from neve.export.solids import FAR, MOST_HEIGHTS, surfaces
from neve.geometry.heights import thinned, triangulated
from neve.render.path_tracing.solids import _field
from neve.scene.reading.load import load
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.shapes import FORMULAS
from neve.scene.values.surfaces import COLUMNS, ROWS

CLOSED = [shape for shape in (*FORMULAS, Layer) if not shape.endless]

VOLUMES = {
    "box": 8.0,
    # a prism over a polygon of n corners: n/2 sin(2 pi / n) times the height 2
    "cylinder": COLUMNS * math.sin(2 * math.pi / COLUMNS),
}


@pytest.mark.parametrize("shape", CLOSED, ids=lambda shape: shape.__name__)
def test_a_shape_of_a_formula_has_a_closed_surface(shape):
    """Watertight, outward, with half extents of 1, and the volume of its polyhedron."""
    vertices, faces = shape.unit_surface()
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    np.testing.assert_allclose(mesh.bounds, [[-1, -1, -1], [1, 1, 1]], atol=1e-12)
    word = shape.model_fields["shape"].default
    if word in VOLUMES:
        assert mesh.volume == pytest.approx(VOLUMES[word], rel=1e-12)
    else:  # a ball, but for the sagittas of rows and columns
        full = shape.volume_of(np.ones(3))
        short = 1 - (math.pi / ROWS) ** 2 / 4 - (math.pi / COLUMNS) ** 2
        assert short * full < mesh.volume <= full * (1 + 1e-12)


def test_solids_of_a_scene(finished):
    """Each that can be seen, in order, in the unit of the file; a plane is a square that faces its normal."""
    found = surfaces(solids(load(finished)), 100.0)
    assert [surface.name for _, surface in found] == ["colliders.0", "colliders.1", "bodies.0"]
    plane, box, _ = (surface for _, surface in found)
    assert np.abs(plane.vertices).max() == 100.0 * FAR
    a, b, c = plane.vertices[plane.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
    np.testing.assert_allclose(box.vertices.max(axis=0), [30.0, 50.0, 70.0], rtol=1e-6)


def test_words_of_solids_are_plain_and_differ():
    """Robots have geoms of any name: what two formats allow is kept, and no two become one."""
    names = ["robots.0.wheel left", "robots.0.wheel-left", "robots.0.Räd", "robots_0_wheel_left", "bodies.1"]
    found = surfaces(tuple(Solid(name, "box", np.ones(3)) for name in names), 1.0)
    words = [surface.word for _, surface in found]
    assert len({*words}) == 5
    assert all(word.isascii() and word.replace("_", "a").isalnum() for word in words)
    assert [surface.name for _, surface in found] == names
    assert words[4] == "bodies_1"


def test_a_terrain_is_its_map(tmp_path):
    """Heights on their places; seen from above all triangles turn anticlockwise."""
    heights = np.random.default_rng(1).random((5, 4))
    np.save(tmp_path / "map.npy", heights)
    (tmp_path / "scene.toml").write_text(
        '[[sources]]\nshape = "sphere"\ncenter = [0.0, 0.0, 3.0]\n[[colliders]]\nshape = "terrain"\n'
        'file = "map.npy"\nsize = [8.0, 3.0]\n'
    )
    (terrain,) = solids(load(tmp_path / "scene.toml"))
    vertices, faces = triangles(terrain, FAR, MOST_HEIGHTS)
    assert vertices[0].tolist() == [-4.0, -1.5, pytest.approx(heights[0, 0])]
    assert vertices[-1].tolist() == [4.0, 1.5, pytest.approx(heights[-1, -1])]
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(24.0)


@pytest.mark.parametrize("shape", [(2600, 9), (7, 1500), (3, 2)])
def test_a_thinned_map_stays_where_it_is(shape):
    """On a slope z = x + 2 y, whatever rows are left out, each corner of exports and pictures is on it."""
    x, y = (np.linspace(-0.5, 0.5, n) * length for n, length in zip(shape, (8.0, 3.0), strict=True))
    slope = (x[:, None] + 2 * y).astype(np.float32)
    for most in (MOST_HEIGHTS, 1024):
        u, v, z = thinned(slope, (8.0, 3.0), most)
        assert max(len(u), len(v)) <= most
        assert (u[0], u[-1], v[0], v[-1]) == (-4.0, 4.0, -1.5, 1.5)
        assert z == pytest.approx(u[:, None] + 2 * v, abs=1e-5)
        corners, faces = triangulated(u, v, z)
        assert corners[:, 2] == pytest.approx(corners[:, 0] + 2 * corners[:, 1], abs=1e-5)
        assert len(faces) == 2 * (len(u) - 1) * (len(v) - 1)


def test_a_terrain_is_painted_where_it_is_pressed():
    """The terrain of a picture, too, with a level rim beyond its edge."""
    heights = np.linspace(-4.0, 4.0, 2600, dtype=np.float32)[:, None] * np.ones(9, np.float32)
    corners, _ = _field(heights, (8.0, 3.0))
    inside = np.abs(corners[:, 0]) <= 4.0
    assert corners[inside, 2] == pytest.approx(corners[inside, 0], abs=1e-5)
    assert corners[~inside, 2] == pytest.approx(4.0 * np.sign(corners[~inside, 0]))
