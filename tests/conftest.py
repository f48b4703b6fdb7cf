"""Shared by all tests."""

import os
import tempfile

# The tests are many short runs, often on a busy machine: threads that wait sleep, and LAPACK uses one.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from reference.laws import LAWS

from neve.scene.values.choices import SPLINES, TRANSFERS

# Grids of distances are made anew, in a folder that goes with the tests: never in the user's own.
CACHE = tempfile.TemporaryDirectory(prefix="neve-cache-")
os.environ["NEVE_CACHE"] = CACHE.name


def pytest_configure(config):
    """Let scenes of the tests be coarse on purpose; tests/scene/checks/test_advice.py tests the warnings."""
    config.addinivalue_line("filterwarnings", "ignore::neve.scene.errors.SceneWarning")


@pytest.fixture(params=["float32", "float64"])
def precision(request):
    """Number format of particles and grid, a value of `numerics.precision`."""
    return request.param


@pytest.fixture
def core(precision):
    """The compiled functions of one precision."""
    from neve import _core

    return {"float32": _core.f32, "float64": _core.f64}[precision]


@pytest.fixture
def eps(precision):
    """Distance from 1 to the next number."""
    return float(np.finfo(precision).eps)


@pytest.fixture(params=list(SPLINES))
def spline(request):
    return request.param


@pytest.fixture(params=list(TRANSFERS))
def transfer(request):
    return request.param


@pytest.fixture(params=[name for name, transfer in TRANSFERS.items() if not transfer.damps])
def lively_transfer(request):
    """A transfer that does not damp: with the others waves fade within cells."""
    return request.param


@pytest.fixture(params=list(LAWS))
def law(request):
    """A snow of the oracle for each constitutive law and variant."""
    return LAWS[request.param]
