"""Meshes and terrain as solids of the step: by packs as by points, and as the bodies they stand for."""

import gc
from functools import cache

import numpy as np
import pytest
from reference import contact, meshes
from reference.snow import rotation
from verification.stages import Lab

from neve import _core

DX, DT = 0.05, 1e-4
TURN = rotation(np.random.default_rng(7).standard_normal((1, 3, 3)))[0]


def sdf(body, spacing=DX / 2, cells=4):
    return _core.geometry.SdfGrid.build(meshes.native(*body), spacing, cells * spacing)


def hills(x, y):
    return 0.2 * np.sin(3 * x) + 0.1 * np.cos(4 * y)


def field(height, size=2.0, n=81):
    x = np.linspace(-size / 2, size / 2, n)
    return _core.geometry.HeightField(
        np.float32(height(x[:, None], x[None, :]) + 0 * x[:, None] * x), (size, size)
    )


def lab(core, precision, seed=0, low=(-0.3, -0.3, -0.1), high=(0.3, 0.3, 0.35), spline="quadratic"):
    """A cloud of snow that falls at 3 m/s, with some motion of its own."""
    rng = np.random.default_rng(seed)
    n = 4000
    values = {
        "x": rng.uniform(low, high, (n, 3)),
        "v": rng.standard_normal((n, 3)) * 0.2 - [0, 0, 3.0],
        "m": np.full(n, 400 * DX**3 / 8),
        "V0": np.full(n, DX**3 / 8),
    }
    return Lab(core, precision, spline, "apic", dx=DX, **values)


def add(lab, solid, mode, position=(0.0, 0.0, 0.0), turn=None):
    """Add a solid from a grid or a height field, in its place."""
    is_mesh = isinstance(solid, _core.geometry.SdfGrid)
    (lab.model.add_mesh_solid if is_mesh else lab.model.add_terrain_solid)(solid, mode, 0.3)
    still = np.zeros(3)
    if hasattr(lab, "make_room"):
        lab.make_room()
    lab.model.place_solid(0, np.asarray(position, float), np.eye(3) if turn is None else turn, still, still)


def exchanged(lab, body=None):
    """What one step gives to the only solid: impulse, moment and work (7,); `body`: a collider by formula."""
    if body is not None:
        lab.add_body(body)
    lab.step(DT)
    return lab.grid.take_exchanged(1)[0]


def test_packs_say_what_points_say(core, precision, eps):
    """In the world, by packs and in the precision of the step: rounding of lengths of 1 m over the spacing.

    phi changes by 2 m per m of place at most, a normal by 2 per spacing; a place is rounded four times.
    """
    spacing, place = 0.05, np.array([0.3, -0.2, 0.1])
    x = np.random.default_rng(0).uniform(-1, 1, (1003, 3))
    for solid in (sdf(meshes.torus(0.5, 0.2, 24, 12), spacing), field(hills)):
        model = core.Model(DX, "quadratic", "apic", 0.95, np.zeros(3))
        add(type("Lab", (), {"model": model}), solid, "slip", place, TURN)
        phi, n = model.surface(0, x)
        expected, normal = solid.sample(x * 1.0 @ TURN - place @ TURN)
        np.testing.assert_allclose(phi, expected, rtol=0, atol=20 * eps)
        off = np.abs(n - normal @ TURN.T).max(1)
        assert (off < 40 * eps / spacing).mean() > 0.999  # but at the sides of bricks or of the field
        np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1, atol=4 * eps)


@cache
def ball(radius, spacing):
    """A ball of 8192 triangles, its grid, and how far inside the ball its faces lie [m]."""
    v, f = meshes.sphere(5, radius)
    n = meshes.unit(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]))
    return sdf((v, f), spacing, 2), radius - np.sum(n * v[f[:, 0]], 1).min()


@pytest.mark.parametrize("mode", ["sticky", "slip", "separate"])
def test_a_ball_of_triangles_is_a_ball(core, precision, mode):
    """The impulse and moment it exchanges are the ball's within what its faces and blends tilt.

    A face lies s = 0.3 mm inside the ball of 0.3 m, so normals, differences over 2 h, tilt by up to
    sqrt(3) s / 2h = 2 %; impulses of nodes and particles err by that, their sum by less. Blends add h^2 / 4 r
    to s; no node is so near under the ball, where one would hold it and the other not.
    """
    radius, h, center = 0.3, DX / 4, np.array([0.0086, 0.0412, 0.0341])
    solid, sagitta = ball(radius, h)
    shell = sagitta + h**2 / 4 / radius
    nodes = DX * np.stack(np.meshgrid(*[np.arange(-8, 9)] * 3), -1).reshape(-1, 3)
    gap = np.linalg.norm(nodes - center, axis=1) - radius
    assert not ((gap < 1e-4 * DX) & (gap > -1.1 * shell)).any()
    a = lab(core, precision)
    add(a, solid, mode, center)
    b = contact.Body("sphere", mode, 0.3, (radius,), center)
    found, expected = exchanged(a), exchanged(lab(core, precision), b)
    size = np.linalg.norm(expected[:3])
    assert size > 1
    np.testing.assert_allclose(found[:3], expected[:3], rtol=0, atol=0.02 * size)
    np.testing.assert_allclose(found[3:6], expected[3:6], rtol=0, atol=0.02 * radius * size)


@pytest.mark.parametrize("mode", ["sticky", "separate"])
def test_level_ground_is_a_plane(core, precision, eps, mode):
    """A field of equal heights gives and takes what a plane does, to rounding of 4000 particles' momenta."""
    a = lab(core, precision)
    add(a, field(lambda x, y: 0.0813), mode)
    b = contact.Body("plane", mode, 0.3, (), np.array([0, 0, 0.0813]))
    found, expected = exchanged(a), exchanged(lab(core, precision), b)
    expected[3:6] += np.cross([0, 0, 0.0813], expected[:3])  # the moment about the plane's own point
    scale = np.linalg.norm(expected[:3])
    np.testing.assert_allclose(found, expected, rtol=0, atol=100 * eps * scale)


@pytest.mark.parametrize("solid", ["mesh", "terrain"])
def test_far_solids_are_passed_over(core, precision, solid):
    """Snow beyond reach exchanges nothing; the same snow where the solid is does."""
    made = sdf(meshes.sphere(2, 0.2)) if solid == "mesh" else field(hills)
    for height, meets in ((0.0, True), (-1.2, False)):
        a = lab(core, precision)
        add(a, made, "sticky", (0.0, 0.0, height), TURN if solid == "mesh" else None)
        assert exchanged(a).any() == meets


def test_near_is_never_missed(core, precision):
    """Blocks of nodes and homes of particles ask for all that is near: skins, corners, insides.

    A box of triangles with faces on nothing round, turned, holds exactly the nodes that its distance
    says: after a sticky step they are at rest, wherever in a block they are.
    """
    body = (meshes.box((0.37, 0.23, 0.31))[0] @ TURN.T, meshes.box()[1])
    a = lab(core, precision)
    solid = sdf(body)
    add(a, solid, "sticky", (0.05, 0.02, 0.1))
    a.p2g(DT)
    a.grid_update(DT)
    ijk, _, v = a.grid.nodes()
    phi, _ = solid.sample(DX * ijk - [0.05, 0.02, 0.1])
    inside = phi < -1e-5
    assert inside.sum() > 100
    assert (v[inside] == 0).all()
    assert (np.linalg.norm(v[phi > 1e-3], axis=1) > 0.5).all()


def test_the_model_keeps_its_solids(core, precision):
    """Grid and field outlive the names that made them."""
    a = lab(core, precision)
    add(a, sdf(meshes.sphere(2, 0.2)), "sticky")
    gc.collect()
    assert exchanged(a)[2] < 0
