"""Density on a sparse grid: what the particles hold is what the cells hold."""

import numpy as np
import pytest

from neve._surface import Field
from neve.surface.volume import density_and_momentum, volume_of

RNG = np.random.default_rng(3)


def density_of(x, mass, cell_size):
    """The density of particles at rest."""
    return volume_of(density_and_momentum(x, mass, np.zeros_like(x), cell_size)[0])


def test_cells_hold_the_mass_of_the_particles():
    """Weights of a B-spline sum to one: the integral of the density is the mass, to rounding of float32."""
    x = RNG.normal(size=(5000, 3)) * [2.0, 0.3, 0.7]
    mass = RNG.uniform(0.5, 1.5, 5000)
    assert density_of(x, mass, 0.1).total == pytest.approx(mass.sum(), rel=1e-6)


def test_cells_hold_the_momentum_of_the_particles():
    """Momentum sums up to that of the particles, and is rho u with one u everywhere if all move alike."""
    x, mass, v = RNG.normal(size=(3000, 3)), RNG.uniform(0.5, 1.5, 3000), RNG.normal(size=(3000, 3))
    _, momentum = density_and_momentum(x, mass, v, 0.2)
    assert momentum.sum(axis=(0, 1, 2, 3)) * 0.2**3 == pytest.approx(mass @ v, rel=1e-4, abs=1e-3)
    u = np.array([2.0, -1.0, 0.5], np.float32)
    field, momentum = density_and_momentum(x, mass, np.tile(u, (3000, 1)), 0.2)
    assert momentum == pytest.approx(field.values()[..., None] * u, rel=1e-5, abs=1e-4)


def test_density_is_that_of_the_kernel():
    """Density of one particle at each cell centre: m / h^3 times the product of quadratic B-splines."""
    x, h = np.array([[0.137, -0.62, 0.911]]), 0.25
    dense, corner = density_of(x, 2.0, h).dense()
    for cell in np.ndindex(*dense.shape):
        s = (corner + (np.array(cell) + 0.5) * h - x[0]) / h
        expected = 2.0 / h**3 * np.prod([b_spline(a) for a in s])
        assert dense[cell] == pytest.approx(expected, abs=1e-4)


def b_spline(a):
    """The quadratic B-spline."""
    a = abs(a)
    return 0.75 - a * a if a < 0.5 else 0.5 * (1.5 - a) ** 2 if a < 1.5 else 0.0


@pytest.mark.parametrize("blurs", [0, 1, 3])
def test_blur_keeps_the_sum_and_adds_its_variance(blurs):
    """The field of a point has variance h^2/4 of the B-spline and h^2/2 of each blur along each axis; its
    mean is where the point is."""
    x, h = np.array([[0.31, -0.2, 0.77]], np.float32), 0.1
    dense, corner = volume_of(Field(x, np.ones(1, np.float32), h, blurs)).dense()
    assert dense.sum() == pytest.approx(1.0, rel=1e-6)
    for axis in range(3):
        at = corner[axis] + (np.arange(dense.shape[axis]) + 0.5) * h
        share = dense.sum(axis=tuple({0, 1, 2} - {axis})).astype(float)
        mean = share @ at
        assert mean == pytest.approx(x[0, axis], abs=1e-6)
        assert share @ (at - mean) ** 2 == pytest.approx(h * h * (0.25 + 0.5 * blurs), rel=1e-5)


def test_particles_that_are_nowhere_are_left_out():
    """A particle that is not finite adds nothing, and none at all are an empty volume."""
    x = np.array([[0, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]])
    assert density_of(x, 1.0, 0.5).total == pytest.approx(1.0, rel=1e-6)
    empty = density_of(np.zeros((0, 3)), 1.0, 0.5)
    assert empty.total == 0.0
    assert empty.dense()[0].size == 0


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"cell_size": 0.0}, "cell_size"),
        ({"cell_size": float("nan")}, "cell_size"),
        ({"amounts": np.ones(2, np.float32)}, "amounts"),
        ({"blurs": -1}, "blurs"),
    ],
)
def test_wrong_sizes_are_refused(keywords, said):
    """Sizes that make no field are a ValueError that names them."""
    given = {"x": np.zeros((3, 3), np.float32), "amounts": np.ones(1, np.float32), "cell_size": 0.1}
    with pytest.raises(ValueError, match=said):
        Field(**(given | keywords))
