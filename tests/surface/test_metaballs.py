"""Metaballs: the kernel, one ball, two that merge, and packed snow."""

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from neve.surface.metaballs import Metaballs, kernel, snow_balls, surface_radius

ONE = np.ones(1, np.float32)
RNG = np.random.default_rng(8)


def test_kernel_has_its_values_and_slopes():
    """f(0) = 1, f(1/2) = 1/2, f(1) = 0; the slope is zero at 0 and 1, by central differences."""
    assert kernel(np.array([0.0, 0.5, 1.0, 3.0])) == pytest.approx([1.0, 0.5, 0.0, 0.0], abs=1e-15)
    for a in (0.0, 1.0):
        assert (kernel(abs(a + 1e-6)) - kernel(abs(a - 1e-6))) / 2e-6 == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("level", [0.05, 0.3, 0.5, 0.9])
def test_one_ball_is_a_sphere_of_known_radius(level):
    """The surface f(r/R) = T is the sphere of the root of the cubic in (r/R)^2; surface nets lie within
    h^2 / r of it, and its volume is 4/3 pi r^3."""
    radius, h, centre = 0.8, 0.03, np.array([0.1, -0.2, 0.4], np.float32)
    ball = Metaballs(centre[None], radius, ONE)
    r = radius * surface_radius(level)
    assert float(kernel(r / radius)) == pytest.approx(level, abs=1e-12)
    mesh = ball.surface(level, h)
    far = np.linalg.norm(mesh.vertices - centre, axis=1)
    assert np.abs(far - r).max() < h * h / r
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * r**3, rel=3 * (h / r) ** 2 + 0.005)
    assert np.einsum("ij,ij->i", mesh.normals, (mesh.vertices - centre) / far[:, None]).min() > 0.99


def test_grid_holds_the_formula():
    """The cells of the field are the sum of kernels, to rounding of float32."""
    balls = Metaballs(RNG.uniform(-1, 1, (50, 3)).astype(np.float32), 0.4, np.full(50, 0.7, np.float32))
    volume = balls.volume(0.1)
    dense, corner = volume.dense()
    cells = RNG.integers(0, dense.shape, (300, 3))
    at = corner + (cells + 0.5) * volume.cell_size
    assert dense[tuple(cells.T)] == pytest.approx(balls.at(at), abs=2e-5)


def test_surface_is_where_the_formula_says():
    """On the surface of many balls the sum of kernels is the level, to the cell's curvature."""
    balls = Metaballs(RNG.uniform(-0.5, 0.5, (40, 3)).astype(np.float32), 0.4, ONE)
    mesh = balls.surface(0.5, 0.02)
    assert np.abs(balls.at(mesh.vertices) - 0.5).max() < 0.03


@pytest.mark.parametrize(("apart", "pieces"), [(0.9, 1), (1.1, 1), (1.4, 2)])
def test_two_balls_merge_where_their_sum_does(apart, pieces):
    """Halfway between two balls the field is 2 f(d / 2R): they are one piece if that is above the level."""
    level = 0.5
    assert (2 * float(kernel(apart / 2)) > level) == (pieces == 1)
    balls = Metaballs(np.array([[0, 0, 0], [apart, 0, 0]], np.float32), 1.0, ONE)
    mesh = balls.surface(level, 0.04)
    n = len(mesh.vertices)
    pairs = mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(n, n))
    assert connected_components(graph)[0] == pieces


def test_merging_is_smooth():
    """Where two balls meet, normals of neighbouring vertices turn by little: there is no crease."""
    balls = Metaballs(np.array([[0, 0, 0], [1.0, 0, 0]], np.float32), 1.0, ONE)
    mesh = balls.surface(0.5, 0.03)
    a, b = mesh.normals[mesh.faces[:, 0]], mesh.normals[mesh.faces[:, 1]]
    assert np.einsum("ij,ij->i", a, b).min() > np.cos(np.radians(12))


def test_packed_snow_is_one():
    """Balls on a lattice, each of the volume that a particle takes: the field inside is 1 within 3 %."""
    h = 0.1
    x = np.stack(np.meshgrid(*[np.arange(12)] * 3, indexing="ij"), -1).reshape(-1, 3) * h
    balls = snow_balls(x, h)
    inside = RNG.uniform(0.4, 0.7, (500, 3))
    assert balls.at(inside) == pytest.approx(np.ones(500), abs=0.03)


@pytest.mark.parametrize("level", [0.0, 1.0, -1.0, float("nan")])
def test_a_level_that_no_ball_has_is_refused(level):
    """One ball has values between 0 and 1."""
    with pytest.raises(ValueError, match="level is above 0 and below 1"):
        surface_radius(level)
