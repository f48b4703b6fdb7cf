"""Elastic snow takes the short way through its law, and snow that flows does not.

Results agree whichever way it was: an elasticity that answers on the short way alone tells it.
"""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from device.compiled import library
from verification.material import turns

THETA_C, THETA_S = 2.5e-2, 7.5e-3
NUMBER = {"float32": ctypes.c_float, "float64": ctypes.c_double}


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The library of short_way.cpp."""
    return library(Path(__file__).with_name("short_way.cpp"), tmp_path_factory.mktemp("short_way"))


@pytest.fixture
def ways(compiled, precision):
    """Return (map, stress): whether a pack took the short way, its first lanes being stretched by 1 + e."""
    number, lanes = NUMBER[precision], getattr(compiled, f"lanes_{precision}")()

    def of(*strains):
        F = np.zeros((lanes, 3, 3))
        F[:] = np.eye(3)
        for lane, e in enumerate(strains):
            F[lane] = np.diag(1 + np.asarray(e, float))
        F[: len(strains)] = turns(len(strains), 1) @ F[: len(strains)] @ turns(len(strains), 2)
        F = np.ascontiguousarray(F, precision)
        out = (ctypes.c_int * lanes)(), (ctypes.c_int * lanes)()
        getattr(compiled, f"ways_{precision}")(
            F.ctypes.data_as(ctypes.c_void_p), number(THETA_C), number(THETA_S), *out
        )
        found = [set(lane) for lane in out]
        assert all(len(ways) == 1 for ways in found)  # a pack goes one way
        return tuple(bool(ways.pop()) for ways in found)

    return of


@pytest.mark.parametrize(
    "e",
    [
        (0, 0, 0),
        (0.95 * THETA_S, 0.95 * THETA_S, 0.95 * THETA_S),
        (-0.95 * THETA_C, -0.95 * THETA_C, -0.95 * THETA_C),
        (0.95 * THETA_S, -0.95 * THETA_C, 0),
        (-0.95 * THETA_C, 1e-4, 0.95 * THETA_S),
    ],
)
def test_elastic_snow_takes_it(ways, e):
    """Strains between the critical ones, by more than the bounds are drawn in (1 %): no eigenvalues."""
    assert ways(e, (0, 0, 0), e) == (True, True)


@pytest.mark.parametrize("e", [(1.001 * THETA_S, 0, 0), (0, -1.001 * THETA_C, 0), (0, 0, -0.03)])
def test_one_that_flows_takes_all_of_its_pack_the_long_way(ways, e):
    """A strain beyond a critical one needs the eigenvalues; the stress of such a state does not."""
    assert ways((0, 0, 0), e) == (False, True)


def test_strains_that_are_not_small_take_the_long_way(ways):
    """Beyond small_strain, |s^2 - 1| = 0.0625, the series of the short way end too early."""
    assert ways((-0.028, 0, 0))[1]
    assert not ways((-0.034, 0, 0))[1]
    assert not ways((0.034, 0, 0))[1]


def test_a_mirror_takes_the_long_way(ways):
    """F = diag(1, 1, -1) has no strain F F^T - I, and is not elastic."""
    assert ways((0, 0, -2)) == (False, False)
