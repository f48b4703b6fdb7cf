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
def gpus(library):
    """Three of them, each with memory that no other can touch; the first."""
    gc.collect()
    stand_ins = [StandIn(library, number, devices=3) for number in range(3)]
    with plugged_in(*stand_ins) as first:
        yield first
    first.set()
    first.fail()


@pytest.fixture
def some_gpus(request):
    """The three stand-ins, as `gpus`; or with NEVE_TEST_GPU=1 the GPU of this machine."""
    return None if REAL else request.getfixturevalue("gpus")


@pytest.fixture
def some_gpu(request):
    """The stand-in; or with NEVE_TEST_GPU=1 the GPU of this machine."""
    return None if REAL else request.getfixturevalue("gpu")
