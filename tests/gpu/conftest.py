"""A GPU where there is none."""

import pytest
from gpu.stand_in import StandIn, build, plugged_in


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The library of the stand-in."""
    return build(tmp_path_factory.mktemp("gpu"))


@pytest.fixture
def gpu(library):
    """The stand-in, which `numerics.device = "cuda"` finds."""
    stand_in = StandIn(library)
    with plugged_in(stand_in):
        yield stand_in
    stand_in.fail()
