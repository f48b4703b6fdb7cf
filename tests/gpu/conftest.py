"""A GPU where there is none."""

import gc

import pytest
from gpu.runs import REAL
from gpu.stand_in import StandIn, build, plugged_in


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The library of the stand-in."""
    return build(tmp_path_factory.mktemp("gpu"))


@pytest.fixture
def gpu(library):
    """The stand-in, which `numerics.device = "cuda"` finds."""
    gc.collect()  # what simulations of other tests hold of its memory
    stand_in = StandIn(library)
    with plugged_in(stand_in):
        yield stand_in
    stand_in.fail()


@pytest.fixture
def some_gpu(request):
    """The stand-in; or with NEVE_TEST_GPU=1 the GPU of this machine."""
    return None if REAL else request.getfixturevalue("gpu")
