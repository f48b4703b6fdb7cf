"""Nearest points, rays and winding numbers of triangle meshes against sums over all triangles."""

import numpy as np
import pytest
from reference import meshes

from neve import _core

BODIES = {
    "box": meshes.box((1.0, 2.0, 0.5)),
    "sphere": meshes.sphere(4),
    "torus": meshes.torus(1.0, 0.3, 40, 20),
    "two boxes that share an edge": meshes.join(meshes.box(), meshes.box(center=(1.0, 1.0, 0.0))),
    "boxes through one another": meshes.join(meshes.box(), meshes.box((0.5, 0.5, 3.0), (0.2, 0.1, 0.0))),
    "half of a sphere": (lambda v, f: (v, f[v[f].mean(1)[:, 2] < 0]))(*meshes.sphere(3)),
}
ROUNDING = 1e-13  # a few hundred operations of 1e-16 on lengths of about 1 m


def points(n=300, reach=1.6, seed=0):
    return np.random.default_rng(seed).uniform(-reach, reach, (n, 3))


@pytest.fixture(params=BODIES)
def body(request):
    return BODIES[request.param]


@pytest.fixture(params=["as made", "soup"])
def mesh(request, body):
    """The core's mesh, as made and as a shuffled soup of triangles with corners of their own."""
    return meshes.native(*(meshes.soup(*body) if request.param == "soup" else body))


def test_distance_is_the_least_of_all(body, mesh):
    """Exact but for rounding; the nearest points lie that far away, on a triangle of the face named."""
    x = points()
    np.testing.assert_allclose(mesh.distance(x), meshes.distance(*body, x), rtol=0, atol=ROUNDING)
    at, distance, _ = mesh.closest(x)
    np.testing.assert_allclose(np.linalg.norm(x - at, axis=1), distance, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(meshes.distance(*body, at), 0, atol=ROUNDING)


def test_closest_names_the_face():
    """The point that `closest` names lies on the triangle that it names, in the order given."""
    v, f = meshes.soup(*BODIES["torus"])
    at, _, face = meshes.native(v, f).closest(points())
    for p, i in zip(at, face, strict=True):
        assert meshes.distance(v, f[i : i + 1], p[None])[0] < ROUNDING


def test_distance_to_thin_triangles():
    """Needles of height 1e-6: the foot of the perpendicular is as far as rounding over the height, 1e-10."""
    rng = np.random.default_rng(1)
    a = rng.standard_normal((50, 3))
    along, aside = rng.standard_normal((2, 50, 3))
    v = np.stack([a, a + along, a + 0.4 * along + 1e-6 * aside], 1).reshape(-1, 3)
    f = np.arange(150).reshape(-1, 3)
    np.testing.assert_allclose(
        meshes.native(v, f).distance(points()), meshes.distance(v, f, points()), rtol=0, atol=1e-9
    )


def test_ray_meets_the_first_triangle(body, mesh):
    """Exact but for rounding, from outside and from inside, with directions of any length.

    No ray of these random ones runs within rounding of an edge, where brute force itself is undecided.
    """
    rng = np.random.default_rng(2)
    origin, direction = points(400, seed=3), rng.standard_normal((400, 3)) * rng.uniform(0.1, 10, (400, 1))
    t, face = mesh.ray(origin, direction)
    expected = meshes.ray(*body, origin, direction)
    hit = np.isfinite(expected)
    assert 10 < hit.sum() < 390
    np.testing.assert_allclose(t, expected, rtol=1e-11)
    assert ((face >= 0) == hit).all()


def test_no_ray_slips_between_triangles():
    """Rays at corners and edges of a sphere, from near it or through it: each meets it, however sums round.

    Left out are those that pass within 0.3 of the tangent plane (faces turn by 0.2 from one to the next),
    which may touch a corner and miss the body.
    """
    v, f = meshes.sphere(3)
    mesh = meshes.native(v, f)
    edges = np.concatenate([v[f[:, k]] + v[f[:, (k + 1) % 3]] for k in range(3)]) / 2
    targets = np.concatenate([v, edges])
    origin = 3 * meshes.unit(np.random.default_rng(4).standard_normal((len(targets), 3)))
    for start in (origin, -2 * targets, 2 * targets, np.round(targets) + 4 * np.sign(targets)):
        way = targets - start
        steep = np.abs(np.sum(meshes.unit(way) * meshes.unit(targets), 1)) > 0.3
        assert steep.sum() > 1000
        t, _ = mesh.ray(start[steep], way[steep])
        assert (t <= 1 + 1e-12).all()


def test_ray_in_the_plane_of_a_box():
    """Rays parallel to an axis, some of them within a face's own box of no thickness, find the front face."""
    mesh = meshes.native(*meshes.box())
    origin = np.array([[-2.0, 0.1, 0.2], [-2.0, 0.5, 0.2], [-2.0, 0.5, -0.5], [-2.0, 0.6, 0.0]])
    t, _ = mesh.ray(origin, np.tile([1.0, 0.0, 0.0], (4, 1)))
    assert (t[0], t[3]) == (pytest.approx(1.5), np.inf)


def test_winding_number_is_the_sum_of_solid_angles(body, mesh):
    """Exact: rounding of some hundred solid angles. In groups: within 0.03, of which 0.5 decides."""
    x = points()
    expected = meshes.winding(*body, x)
    np.testing.assert_allclose(mesh.winding(x, exact=True), expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(mesh.winding(x), expected, rtol=0, atol=0.03)


def test_grouped_winding_number_next_to_the_surface():
    """20,000 wavy triangles, 0.02 m to 0.2 m from them: the groups are within 0.03 of the exact sum.

    The series stops after the first moment, so a group of radius a leaves out (a / r)^2 < 1/9 of what it
    contributes, with alternating signs.
    """
    v, f = meshes.torus(1.0, 0.4, 160, 64)
    v = v * (1 + 0.1 * np.sin(9 * v[:, :1] + 5 * v[:, 2:]))
    mesh = meshes.native(v, f)
    x = points(4000, 1.5)
    d = mesh.distance(x)
    x = x[(d > 0.02) & (d < 0.2)]
    assert len(x) > 300
    np.testing.assert_allclose(mesh.winding(x), mesh.winding(x, exact=True), rtol=0, atol=0.03)


def test_closed_meshes_wind_whole_times(body, mesh):
    """A closed mesh winds 0, 1 or 2 times; overlapping bodies twice. The open one is not closed."""
    w = mesh.winding(points(2000), exact=True)
    whole = np.abs(w - np.round(w)).max() < 1e-12
    assert mesh.closed == whole == (body is not BODIES["half of a sphere"])
    if body is BODIES["boxes through one another"]:
        assert set(np.round(w).astype(int)) == {0, 1, 2}


@pytest.mark.parametrize("name", ["box", "sphere", "torus"])
def test_an_inverted_mesh_is_turned(name):
    """Volume, winding number and signed distance are those of the mesh that looks outwards."""
    v, f = BODIES[name]
    right, wrong = meshes.native(v, f), meshes.native(v, f[:, ::-1])
    assert (right.inverted, wrong.inverted) == (False, True)
    assert right.volume == pytest.approx(wrong.volume)
    for ask in ("winding", "signed_distance"):
        np.testing.assert_allclose(getattr(wrong, ask)(points()), getattr(right, ask)(points()), atol=1e-9)


def test_area_and_volume():
    """A box of 1 x 2 x 0.5 m, and Pappus' volume and area of a torus of n-gons.

    A ring of 40 prisms has the volume A R n sin(2 pi / n), A the area of the tube's polygon.
    """
    box = meshes.native(*BODIES["box"])
    assert (box.area, box.volume) == (pytest.approx(7.0), pytest.approx(1.0))
    np.testing.assert_allclose([box.low, box.high], [[-0.5, -1.0, -0.25], [0.5, 1.0, 0.25]])
    polygon = 0.5 * 20 * 0.3**2 * np.sin(2 * np.pi / 20)
    assert meshes.native(*BODIES["torus"]).volume == pytest.approx(polygon * 40 * np.sin(2 * np.pi / 40))


def test_triangles_without_area_do_not_count():
    """Points, lines and a needle of rounding are passed over; what remains answers as before."""
    v, f = meshes.box()
    needle = [v[0], (v[0] + v[7]) / 2, v[7]]
    v = np.concatenate([v, needle])
    more = np.concatenate([f, [[0, 0, 0], [0, 1, 1], [8, 9, 10]]])
    mesh = meshes.native(v, more)
    assert (mesh.triangles, mesh.skipped) == (12, 3)
    np.testing.assert_array_equal(
        mesh.signed_distance(points()), meshes.native(*meshes.box()).signed_distance(points())
    )


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        (np.zeros((3, 3)), [[0, 1, 2]], "no triangle with an area"),
        (np.zeros((0, 3)), np.zeros((0, 3)), "no triangle with an area"),
        (np.array([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]]), [[0, 1, 2]], "not finite"),
        (np.eye(3), [[0, 1, 3]], "not there"),
        (np.eye(3), [[0, 1, -1]], "not there"),
    ],
)
def test_meshes_that_are_none(vertices, faces, says):
    """Each is refused by name."""
    with pytest.raises(ValueError, match=says):
        meshes.native(vertices, np.asarray(faces))


def test_many_triangles_at_one_place():
    """1000 copies of one triangle share one middle, which no plane divides; the tree still stands."""
    v = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    mesh = meshes.native(v, np.tile([[0, 1, 2]], (1000, 1)))
    np.testing.assert_allclose(mesh.distance(np.array([[0.2, 0.2, 0.7], [2.0, 0, 0]])), [0.7, 1.0])


def test_threads_do_not_matter():
    """The same bits with 1, 2 and 3 threads."""
    mesh = meshes.native(*BODIES["torus"])
    answers = []
    try:
        for n in (1, 2, 3):
            _core.set_threads(n)
            answers.append(mesh.signed_distance(points(1000)).tobytes())
    finally:
        _core.set_threads(1)
    assert answers[0] == answers[1] == answers[2]
