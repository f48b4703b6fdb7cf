"""Anisotropic kernels: their shapes, what they hold, and that flat snow has a flat surface."""

import numpy as np
import pytest

from neve._surface import Field
from neve.surface.kernels import RATIO, REACH, kernels_of
from neve.surface.mesh import snow_surface

RNG = np.random.default_rng(11)
S = 0.1


def turned(rng=RNG):
    """A random rotation."""
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def lattice(counts, jitter, rng=RNG):
    g = np.stack(np.meshgrid(*[np.arange(n) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    return (g + jitter * (rng.random(g.shape) - 0.5)) * S


def test_without_stretch_it_is_the_field_of_points():
    """S = 1 and width = cell_size: the same blocks, and the same values to rounding."""
    x = RNG.random((300, 3)).astype(np.float32)
    amount = RNG.random(300).astype(np.float32)
    plain = Field(x, amount, 0.07, 1)
    found = Field.stretched(x, amount, np.tile(np.eye(3, dtype=np.float32), (300, 1, 1)), 0.07, 0.07, 1)
    places = RNG.random((2000, 3)).astype(np.float32)
    np.testing.assert_allclose(found.sample(places), plain.sample(places), atol=2e-6)


def test_a_kernel_has_its_covariance():
    """A quadratic B-spline has the variance 1/4, so one stretched by S = R diag(s) R^T has width^2 / 4 S^2; a
    cell adds nothing on a fine grid."""
    R = turned()
    stretch = (R * [2.0, 1.0, 0.5]) @ R.T
    x = np.array([[0.31, -0.12, 0.44]], np.float32)
    field = Field.stretched(x, np.ones(1, np.float32), stretch[None].astype(np.float32), 0.4, 0.04)
    values, cells = field.values(), np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1)
    at = (4 * field.blocks()[:, None, None, None] + cells + 0.5) * 0.04 + np.array(field.origin)
    w, d = values.ravel().astype(np.float64), (at - x[0]).reshape(-1, 3)
    assert w.sum() == pytest.approx(1.0, rel=1e-5)
    np.testing.assert_allclose(w @ d, 0.0, atol=1e-3)
    found = np.einsum("i,ij,ik->jk", w, d, d)
    np.testing.assert_allclose(found, 0.25 * 0.4**2 * stretch @ stretch, rtol=0.02, atol=4e-4)


def test_an_ellipsoid_of_neighbours_is_that_of_the_kernel():
    """Pairs of neighbours at +-a_k along three axes: C = diag(2 w_k a_k^2) / sum w, and the kernel's
    stretches are the roots of its eigenvalues over their geometric mean."""
    R, a = turned(), np.array([1.5, 1.0, 0.7]) * S
    x = np.concatenate([np.zeros((1, 3)), *(np.outer([1, -1], a[k] * R[:, k]) for k in range(3))])
    w = 1.0 - (a / (REACH * S)) ** 3
    length = np.sqrt(w) * a
    length /= np.prod(length) ** (1 / 3)
    found = kernels_of(x, S)
    np.testing.assert_allclose(found.stretch[0], (R * length) @ R.T, atol=1e-5)
    np.testing.assert_allclose(found.centres, x, atol=1e-7)


def test_a_sheet_and_a_thread_have_the_flattest_and_the_longest_kernels():
    """Longest over shortest is RATIO, with determinant one; whole packed snow has kernels that are almost
    balls, and so has a lone particle; where it is turned its kernels turn."""
    long, R = RATIO ** (1 / 3), turned()
    sheet = kernels_of(lattice((9, 9, 1), 0.0) @ R.T, S).stretch[40]
    np.testing.assert_allclose(
        sheet, long * (np.eye(3) - (1 - 1 / RATIO) * np.outer(R[:, 2], R[:, 2])), atol=1e-4
    )
    thread = kernels_of(lattice((9, 1, 1), 0.0) @ R.T, S).stretch[4]
    assert np.allclose(thread, np.eye(3))  # it has too few neighbours
    thread = kernels_of(np.outer(np.arange(40) * 0.2 * S, R[:, 0]), S).stretch[20]
    want = (np.eye(3) + (RATIO - 1) * np.outer(R[:, 0], R[:, 0])) / RATIO ** (1 / 3)
    np.testing.assert_allclose(thread, want, atol=1e-4)
    inside = kernels_of(lattice((9, 9, 9), 0.0), S).stretch[364]
    np.testing.assert_allclose(inside, np.eye(3), atol=1e-5)
    assert np.array_equal(kernels_of(np.zeros((1, 3)), S).stretch[0], np.eye(3))


def test_mass_is_kept_and_snow_keeps_its_volume():
    """The field holds what the particles hold; inside the surface of a block that is turned and jittered
    there is the volume of its particles, within 2 %."""
    y = lattice((20, 20, 10), 0.5) @ turned().T
    mass = RNG.random(len(y)).astype(np.float32)
    field = kernels_of(y, S).field(mass, S, 0.5 * S, 1)
    assert field.values().sum(dtype=np.float64) == pytest.approx(mass.sum(dtype=np.float64), rel=1e-5)
    assert snow_surface(y, S, anisotropic=True).volume == pytest.approx(len(y) * S**3, rel=0.02)


def test_flat_snow_is_flat():
    """The side of a turned block, and a sheet one particle thick: at most 0.7 times as rough as with
    round kernels on the same cells; the sheet, which vanishes on cells as large as a particle, is there."""
    R = turned(np.random.default_rng(2))
    block = lattice((20, 20, 8), 0.5, np.random.default_rng(3)) @ R.T
    sheet = lattice((20, 20, 1), 0.5, np.random.default_rng(4)) * [1, 1, 0] @ R.T

    def roughness(mesh, level):
        v = mesh.vertices @ R
        inner = (np.abs(v[:, :2] - 10 * S) < 6 * S).all(axis=1) & (v[:, 2] > level - S)
        return np.abs(v[inner, 2]).std()

    for x, level in ((block, 8 * S), (sheet, S)):
        flat = roughness(snow_surface(x, S, anisotropic=True), level)
        assert flat < 0.12 * S
        assert flat < 0.7 * roughness(snow_surface(x, S, 0.5 * S), level)
    assert snow_surface(sheet, S, anisotropic=True).volume > 0.8 * 400 * S**3
    assert snow_surface(sheet, S).volume < 0.1 * 400 * S**3
