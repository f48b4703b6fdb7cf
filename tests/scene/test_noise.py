"""Fractal noise: mean, spread, smoothness, and independence of everything but the place and the seed."""

from __future__ import annotations

import numpy as np
import pytest

from neve.noise import DEVIATION, fractal

N = 60_000


def places(seed: int = 0, n: int = N) -> np.ndarray:
    """Return `n` points scattered over hundreds of features, on both sides of the origin."""
    return np.random.default_rng(seed).uniform(-100.0, 100.0, (n, 3))


@pytest.mark.parametrize("octaves", [1, 3, 6])
def test_mean_and_spread(octaves: int) -> None:
    """Mean 0 and standard deviation DEVIATION: within 4 standard errors, and 3 % for the cut at 1."""
    value = fractal(places(), 1.0, octaves, seed=5)
    assert abs(value.mean()) < 4 * DEVIATION / np.sqrt(N)
    assert value.std() == pytest.approx(DEVIATION, rel=0.03)
    assert np.abs(value).max() <= 1.0
    assert np.mean(np.abs(value) == 1.0) < 0.02


def test_value_depends_on_the_place_alone() -> None:
    """The same points in another order, or each alone, have the same bits."""
    x = places(n=20_000)
    order = np.random.default_rng(1).permutation(len(x))
    value = fractal(x, 0.3, 4, seed=9)
    assert np.array_equal(fractal(x[order], 0.3, 4, seed=9), value[order])
    assert fractal(x[7:8], 0.3, 4, seed=9)[0] == value[7]


def test_seeds_and_octaves_are_unrelated() -> None:
    """Two seeds are uncorrelated: |r| < 4 / sqrt(n)."""
    a, b = fractal(places(), 1.0, 1, seed=0), fractal(places(), 1.0, 1, seed=1)
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(N)


def test_noise_is_smooth_and_of_the_asked_size() -> None:
    """A thousandth of a feature away the value has hardly changed; two features away it is forgotten."""
    x = places()
    step = np.array([1.0, 0.0, 0.0])
    value = fractal(x, 2.0, 1, seed=3)
    assert np.abs(fractal(x + 0.002 * step, 2.0, 1, seed=3) - value).max() < 0.02
    near = np.corrcoef(fractal(x + 0.4 * step, 2.0, 1, seed=3), value)[0, 1]
    far = np.corrcoef(fractal(x + 4.0 * step, 2.0, 1, seed=3), value)[0, 1]
    assert near > 0.7
    assert abs(far) < 4 / np.sqrt(N)


def test_noise_has_no_jumps() -> None:
    """Along lines through many lattice cells, steps of 0.002 features change it by less than 0.02."""
    t = np.linspace(-10.0, 10.0, 10_001)
    for direction in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.0, -0.8]):
        line = np.outer(t, direction) + np.array([0.3, 0.7, 0.1])
        assert np.abs(np.diff(fractal(line, 1.0, 1, 0))).max() < 0.02
