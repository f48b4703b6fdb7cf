"""What a few comparisons tell a home's particles of a mesh nearby is never more than the mesh says itself."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from device.compiled import library

DX, SIZE, DT = 0.1, 0.5, 1e-3
TILE = 6.0
"""A home at block (0, 0, 0) has particles from half a cell on, over so many cells (quadratic spline)."""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The library of near.cpp."""
    return library(Path(__file__).with_name("near.cpp"), tmp_path_factory.mktemp("near"))


def near_home(compiled, block, x, path, reach=0.0, velocity=(0, 0, 0)):
    """Return (solids kept, phi (n,), may_reach (n,), stays_away (n,)) for an octahedron at the origin."""
    n = len(x)
    x, path = np.ascontiguousarray(x, float), np.ascontiguousarray(path, float)
    phi, may, away = np.empty(n), np.empty(n, np.int32), np.empty(n, np.int32)
    at = [a.ctypes.data_as(ctypes.c_void_p) for a in (x, path, phi, may, away)]
    kept = compiled.near_home(
        ctypes.c_double(SIZE),
        ctypes.c_double(DX),
        (ctypes.c_double * 3)(*velocity),
        (ctypes.c_int * 3)(*block),
        ctypes.c_double(DT),
        ctypes.c_double(reach),
        n,
        *at,
    )
    return kept, phi, may.astype(bool), away.astype(bool)


def points(block, n, seed):
    """Return n points (n, 3) at random where a home has particles [m]."""
    rng = np.random.default_rng(seed)
    return DX * (4 * np.asarray(block) + 0.5 + TILE * rng.random((n, 3)))


BLOCKS = [(0, 0, 0), (1, 0, 0), (-2, -1, 0), (1, 1, 0), (0, -3, 0), (2, 0, 0)]


@pytest.mark.parametrize("block", BLOCKS)
def test_what_is_near_is_not_left_out(compiled, block):
    """Every point that the mesh is within reach of may reach it, and some that are farther are left out."""
    x = points(block, 4000, 1)
    for reach in (0.0, 0.3 * DX, DX):
        kept, phi, may, _ = near_home(compiled, block, x, np.zeros_like(x), reach)
        assert not np.any(~may & (phi <= reach)), (kept, reach)


def test_most_points_far_from_a_mesh_are_left_out(compiled):
    """Of points farther than 2.6 cells (half the diagonal of an eighth of a tile) most are left out."""
    block = (1, 0, 0)
    x = points(block, 4000, 2)
    kept, phi, may, _ = near_home(compiled, block, x, np.zeros_like(x))
    far = phi > 2.6 * DX
    assert kept == 1
    assert far.sum() > 400
    assert (~may[far]).mean() > 0.9


@pytest.mark.parametrize("block", BLOCKS)
@pytest.mark.parametrize("velocity", [(0.0, 0.0, 0.0), (-25.0, 10.0, 0.0)])
def test_who_stays_away_does_not_get_to_it(compiled, block, velocity):
    """A point that is said to stay away is outside at the end of the step, and all along it."""
    rng = np.random.default_rng(3)
    n = 3000
    x = points(block, n, 4)
    path = rng.standard_normal((n, 3)) * rng.choice(
        [1.0, 20.0, 60.0], (n, 1)
    )  # up to a cell and more in a step
    _, _, _, away = near_home(compiled, block, x, path, velocity=velocity)
    for share in np.linspace(0, 1, 9):
        there = x + share * DT * (path - np.asarray(velocity))
        _, phi, _, _ = near_home(compiled, block, there, path, velocity=velocity)
        assert not np.any(away & (phi <= 0)), share


def test_slow_snow_far_from_a_mesh_stays_away(compiled):
    """In a home some cells away, snow that moves by a tenth of a cell stays away; by 1.5, it may not."""
    block = (2, 0, 0)
    x = np.full((1, 3), 0.0) + DX * (4 * np.asarray(block) + 3.5)
    slow, fast = (np.full((1, 3), share * DX / DT / np.sqrt(3)) for share in (0.1, 1.5))
    kept, phi, _, away = near_home(compiled, block, x, slow)
    assert kept in (0, 1)
    assert phi[0] > DX
    assert away[0]
    if kept:
        assert not near_home(compiled, block, x, fast)[3][0]
