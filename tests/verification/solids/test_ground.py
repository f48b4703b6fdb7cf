"""Ground from heights: planes are exact, curved ground is as good as its samples."""

import numpy as np
import pytest

from neve import _core

SIZE = (4.0, 3.0)
STEEP = np.array([0.3, -0.5])


def ground(height, nx=41, ny=31):
    """Sample height(x, y) over the rectangle."""
    x, y = (np.linspace(-s / 2, s / 2, n) for s, n in zip(SIZE, (nx, ny), strict=True))
    return _core.geometry.HeightField(np.float32(height(x[:, None], y[None, :]) + 0 * x[:, None] * y), SIZE)


def points(n=1000, reach=(1.9, 1.4, 2.0), seed=0):
    return np.random.default_rng(seed).uniform(-1, 1, (n, 3)) * reach


def test_flat_ground():
    """phi = z - h and the normal is up, over the rectangle and beyond it."""
    x = points(reach=(9.0, 9.0, 3.0))
    phi, n = ground(lambda x, y: 0.25).sample(x)
    np.testing.assert_allclose(phi, x[:, 2] - 0.25, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(n, np.tile([0.0, 0.0, 1.0], (len(x), 1)))


def test_slope():
    """The plane z = 0.1 + 0.3 x - 0.5 y: float32 heights of 1 m, slopes over 0.1 m."""
    field = ground(lambda x, y: 0.1 + STEEP[0] * x + STEEP[1] * y)
    normal = np.array([*-STEEP, 1.0]) / np.sqrt(1 + STEEP @ STEEP)
    phi, n = field.sample(points())
    np.testing.assert_allclose(phi, (points() - [0, 0, 0.1]) @ normal, rtol=0, atol=2e-6)
    np.testing.assert_allclose(n, np.tile(normal, (1000, 1)), rtol=0, atol=3e-6)


def test_paraboloid():
    """h = (x^2 + y^2) / 2: bilinear heights are high by up to d^2/8 per axis, and slopes exact inside.

    A central difference of a parabola is its slope and a blend of straight slopes is straight, so normals
    are exact but for rounding, where no edge of the rectangle is within a cell.
    """
    d = 0.1
    field = ground(lambda x, y: 0.5 * (x**2 + y**2))
    x = points(reach=(1.85, 1.35, 2.0))
    phi, n = field.sample(x)
    normal = np.stack([-x[:, 0], -x[:, 1], np.ones(len(x))], 1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    np.testing.assert_allclose(n, normal, rtol=0, atol=1e-5)
    high = x[:, 2] - phi / n[:, 2] - 0.5 * (x[:, 0] ** 2 + x[:, 1] ** 2)
    assert high.min() > -1e-6
    assert high.max() < 2 * d**2 / 8 + 1e-6


def test_beyond_the_edge_the_edge_goes_on():
    """Out there the height is that of the nearest point of the rectangle, and falls no more outwards."""
    field = ground(lambda x, y: 0.1 + STEEP[0] * x + STEEP[1] * y)
    x = np.array([[7.0, 0.5, 1.0], [0.5, -8.0, 1.0], [-5.0, 9.0, 1.0]])
    phi, n = field.sample(x)
    at = np.clip(x[:, :2], *np.array([[-2.0, -1.5], [2.0, 1.5]]))
    slope = np.where(np.abs(x[:, :2]) > [2.0, 1.5], 0.0, STEEP)
    n_z = 1 / np.sqrt(1 + np.sum(slope**2, 1))
    np.testing.assert_allclose(n, np.column_stack([-slope, np.ones(3)]) * n_z[:, None], rtol=0, atol=3e-6)
    np.testing.assert_allclose(phi, (1.0 - 0.1 - at @ STEEP) * n_z, rtol=0, atol=2e-6)


def test_deep_below_is_still_inside():
    """However deep, phi is negative: there is no underside."""
    phi, _ = ground(lambda x, y: np.sin(3 * x) * np.cos(2 * y)).sample(points() * 1e3 - [0, 0, 2.1e3])
    assert (phi < 0).all()


def test_says_what_it_holds():
    """Heights come back as given; bounds are the least and the largest."""
    h = np.random.default_rng(0).random((3, 5), dtype=np.float32)
    field = _core.geometry.HeightField(h, SIZE)
    np.testing.assert_array_equal(field.heights, h)
    assert (field.low, field.high, field.size) == (h.min(), h.max(), SIZE)


@pytest.mark.parametrize(
    ("heights", "size", "says"),
    [
        (np.zeros((1, 5)), SIZE, "two samples"),
        (np.zeros((5, 5)), (0.0, 1.0), "size"),
        (np.full((5, 5), np.nan), SIZE, "not finite"),
    ],
)
def test_impossible_ground(heights, size, says):
    """Each is refused by name."""
    with pytest.raises(ValueError, match=says):
        _core.geometry.HeightField(heights.astype(np.float32), size)
