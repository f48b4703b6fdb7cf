"""Polygons of a file are filled as polygons: concave ones, corners in line, not quite flat, with bridges."""

import warnings

import numpy as np
import pytest

from neve.geometry.files.polygons import triangulated
from neve.geometry.sdf import solid_mesh
from neve.scene.schema.scene import Collider

U = [[0, 0], [3, 0], [3, 2], [2, 2], [2, 1], [1, 1], [1, 2], [0, 2]]
POLYGONS = {
    "square": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "dart": [[0, 0], [2, -1], [1, 0], [2, 1]],
    "dart, from another corner": [[2, -1], [1, 0], [2, 1], [0, 0]],
    "quad with a corner in line": [[0, 0], [1, 0], [2, 0], [1, 1]],
    "quad with the first corner in line": [[1, 0], [2, 0], [1, 1], [0, 0]],
    "L": [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]],
    "U": U,
    "U, from another corner": U[5:] + U[:5],
    "corners in line": [[0, 0], [0.1, 0], [0.5, 0], [0.7, 0], [1, 0], [1, 0.5], [1, 1], [0.3, 1], [0, 1]],
    "triangle with many corners": [[k / 9, 0] for k in range(10)] + [[0.5, 1]],
    "comb": [[0, 0], [9, 0]] + [[9 - k, 1 + 3 * (k % 2)] for k in range(10)],
    "spiral": [
        [0, 0], [5, 0], [5, 5], [1, 5], [1, 2], [3, 2], [3, 3], [2, 3], [2, 4], [4, 4], [4, 1], [0, 1],
    ],
    "star": [[np.cos(k * np.pi / 5) * (1 + k % 2), np.sin(k * np.pi / 5) * (1 + k % 2)] for k in range(10)],
    "square with a hole over a bridge": [
        [0, 0], [3, 0], [3, 3], [0, 3], [0, 0], [1, 1], [1, 2], [2, 2], [2, 1], [1, 1],
    ],
}  # fmt: skip
AREAS = {"square with a hole over a bridge": 8.0}


def area(points):
    """Of a polygon in the plane (n, 2): the shoelace formula."""
    x, y = np.transpose(points)
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("what", POLYGONS)
@pytest.mark.parametrize("turn", [0, 1, 3])
def test_triangles_fill_the_polygon(what, turn):
    """n - 2 triangles, none turned round, none of no area, whose areas add up to the polygon's, in any plane;
    each edge of the polygon is an edge of one triangle."""
    flat = np.roll(np.array(POLYGONS[what], dtype=float), turn, axis=0)
    n = len(flat)
    for axes in (np.eye(3), np.eye(3)[[1, 2, 0]], np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])):
        points = np.column_stack([flat, np.zeros(n)]) @ axes + [5.0, -3.0, 2.0]
        faces = triangulated(points, np.arange(n), np.array([n]))
        assert faces.shape == (n - 2, 3)
        found = [area(flat[face]) for face in faces]
        assert min(found) > 1e-9
        assert sum(found) == pytest.approx(AREAS.get(what, area(flat)))
        edges = {(int(f[k]), int(f[(k + 1) % 3])) for f in faces for k in range(3)}
        if what not in AREAS:
            assert {(k, (k + 1) % n) for k in range(n)} <= edges


def test_random_polygons():
    """Star-shaped polygons of 5 to 40 corners, moved out of their plane by 1 % of their size."""
    rng = np.random.default_rng(3)
    for _ in range(60):
        n = int(rng.integers(5, 40))
        angle = np.sort(rng.uniform(0, 2 * np.pi, n))
        if np.diff(angle, append=angle[0] + 2 * np.pi).max() > 3.0:
            continue
        flat = rng.uniform(0.3, 1.0, n)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        points = np.column_stack([flat, 0.01 * rng.standard_normal(n)])
        found = [area(flat[face]) for face in triangulated(points, np.arange(n), np.array([n]))]
        assert sum(found) == pytest.approx(area(flat), rel=1e-3)
        assert min(found) > -1e-3


def prism(outline, height):
    """An OBJ file of a prism over a polygon: two n-gons and a quad on each edge."""
    n = len(outline)
    rows = [f"v {x} {y} {z}" for z in (0.0, height) for x, y in outline]
    faces = [range(n, 0, -1), range(n + 1, 2 * n + 1)]
    faces += [[k + 1, (k + 1) % n + 1, n + (k + 1) % n + 1, n + k + 1] for k in range(n)]
    return "\n".join([*rows, *("f " + " ".join(map(str, face)) for face in faces)])


@pytest.mark.parametrize("what", POLYGONS)
def test_prisms_are_closed(what, surface):
    """V = A h of a prism, and no edge is open."""
    found = surface("a.obj", prism(POLYGONS[what], 0.5))
    assert found.open_edges == 0
    assert found.volume == pytest.approx(0.5 * AREAS.get(what, area(POLYGONS[what])))


def test_groove_of_a_u_is_empty(tmp_path):
    """Nothing is met in the groove of a U-shaped prism: 0.1 m from its walls and its ground phi is that;
    in its arms and its base snow is kept out. Flat walls at h = 0.05 m: exact but for single precision."""
    (tmp_path / "u.obj").write_text(prism(U, 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = solid_mesh(Collider.of("mesh", file=str(tmp_path / "u.obj")), 0.1, "colliders.0")
    points = np.array(
        [[1.5, 1.6, 0.5], [1.5, 1.1, 0.5], [1.1, 1.5, 0.5], [0.5, 1.5, 0.5], [2.5, 1.5, 0.5], [1.5, 0.5, 0.5]]
    )
    phi, _ = mesh.sdf.sample(points)
    assert phi[0] > 0.2
    assert np.asarray(phi)[1:3] == pytest.approx([0.1, 0.1], abs=1e-6)
    assert (np.asarray(phi)[3:] < -0.3).all()
