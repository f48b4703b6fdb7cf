"""A plugin: tests that can run on a GPU run on the stand-in.

export NEVE_TEST_DEVICE=cuda NEVE_SHIM_OPTIMIZED=-O2 PYTHONPATH=tests
pytest -p gpu.rehearsal -m gpu tests/verification
"""

from pathlib import Path

import pytest
from gpu.stand_in import StandIn, build, plugged_in


@pytest.fixture(scope="session", autouse=True)
def stand_in(tmp_path_factory):
    """Plug the stand-in in, for all tests."""
    folder = Path(tmp_path_factory.mktemp("gpu"))
    with plugged_in(StandIn(build(folder))) as found:
        yield found
