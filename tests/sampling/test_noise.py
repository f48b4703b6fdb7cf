"""Fractal noise: mean, spread, smoothness, and independence of everything but the place and the seed."""

from __future__ import annotations

import numpy as np
import pytest

from neve.sampling.noise import DEVIATION, clods, fractal
from neve.sampling.sheets import sheets

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


SIZE = np.array([2.0, 1.5, 1.0])


def in_box(n: int = 40_000, seed: int = 2) -> np.ndarray:
    """Return `n` points scattered over a centred box of edges SIZE."""
    return (np.random.default_rng(seed).random((n, 3)) - 0.5) * SIZE


def test_clods_lie_between_seams() -> None:
    """Noise is 0 inside clods and down to -1 on their walls; the deepest place is on a wall."""
    value = clods(in_box(), SIZE, 0.2, 0.04, 1, seed=4)
    assert value.max() == 0.0
    assert -1.0 <= value.min() < -0.99


def test_share_of_seams() -> None:
    """The share of snow within h of a wall of Poisson-Voronoi cells tends to 5.82 h / a for small h.

    The walls have the area 2.91 / a in a unit of volume, a^3 being the mean volume of a cell (Meijering: a
    cell has the surface 5.82 a^2, and each wall two cells). A share 2 h times that lies within h, less a few
    per cent where walls meet, at h = 0.01 a. The box holds 3,000 cells, so their number, and with it the
    area, is right to some 2 %; of 200,000 points 5 % fall into seams, counted to 1 %.
    """
    a, h = 0.1, 0.001
    value = clods(in_box(200_000), SIZE, a, 2 * h, 1, seed=8)
    assert np.mean(value < 0) == pytest.approx(5.82 * h / a, rel=0.08)


def test_clods_depend_on_the_place_alone() -> None:
    """The same points in another order, or each alone, have the same bits; another seed has other walls."""
    x = in_box(2000)
    order = np.random.default_rng(1).permutation(len(x))
    value = clods(x, SIZE, 0.3, 0.1, 2, seed=9)
    assert np.array_equal(clods(x[order], SIZE, 0.3, 0.1, 2, seed=9), value[order])
    assert clods(x[7:8], SIZE, 0.3, 0.1, 2, seed=9)[0] == value[7]
    assert np.corrcoef(clods(x, SIZE, 0.3, 0.1, 2, seed=10), value)[0, 1] < 0.1


def test_finer_clods_have_shallower_seams() -> None:
    """A second octave only deepens, and its own seams stop at -1/2."""
    x = in_box()
    one, two = (clods(x, SIZE, 0.3, 0.04, octaves, seed=5) for octaves in (1, 2))
    assert np.all(two <= one)
    assert two[one == 0].min() == pytest.approx(-0.5, abs=0.01)
    assert np.mean(two < 0) > np.mean(one < 0)


def test_sheets_weaken_their_middle_alone() -> None:
    """Noise is 0 beside sheets and down to -1 in them; a second octave only deepens, to -1/2 alone."""
    x = in_box()
    one, two = (sheets(x, SIZE, 0.3, 0.04, octaves, seed=5) for octaves in (1, 2))
    assert one.max() == 0.0
    assert -1.0 <= one.min() < -0.99
    assert np.all(two <= one)
    assert two[one == 0].min() == pytest.approx(-0.5, abs=0.01)


def test_share_of_sheets() -> None:
    """Sheets of width w that a line meets once every s fill the share 1 - exp(-2 w / s).

    A line meets half of the area in a unit of volume per unit of length: the area is 2 / s, and what is
    random overlaps as Poisson has it. The number of sheets in the box is some 100: 3 seeds are right to
    some 6 %, and the area inside the box is estimated for flat sheets.
    """
    s, w = 0.2, 0.004
    share = np.mean([np.mean(sheets(in_box(), SIZE, s, w, 1, seed=seed) < 0) for seed in range(3)])
    assert share == pytest.approx(1 - np.exp(-2 * w / s), rel=0.15)


def test_sheets_depend_on_the_place_alone() -> None:
    """The same points in another order, or each alone, have the same bits; another seed has other sheets."""
    x = in_box(2000)
    order = np.random.default_rng(1).permutation(len(x))
    value = sheets(x, SIZE, 0.3, 0.1, 2, seed=9)
    assert np.array_equal(sheets(x[order], SIZE, 0.3, 0.1, 2, seed=9), value[order])
    assert sheets(x[7:8], SIZE, 0.3, 0.1, 2, seed=9)[0] == value[7]
    assert np.corrcoef(sheets(x, SIZE, 0.3, 0.1, 2, seed=10), value)[0, 1] < 0.15
