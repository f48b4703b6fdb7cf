"""Shared by all tests."""

import os
import signal
import tempfile

# The tests are many short runs, often on a busy machine: threads that wait sleep, and LAPACK uses one.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# A job in the background of a shell ignores Ctrl-C, and so would all that the tests start: these hear it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

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


class AtOnce:
    """Names each test when it fails: a run that is ended before its summary has still said what failed."""

    def __init__(self, terminal):
        self.terminal = terminal

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.terminal.ensure_newline()
            self.terminal.write_line(f"failed: {report.nodeid} ({report.when}) {lastline(report)}")


def lastline(report):
    """What a failed test said at its end, at most 200 characters."""
    crash = getattr(report.longrepr, "reprcrash", None)
    return (crash.message if crash else str(report.longrepr)).strip().splitlines()[-1][:200]


@pytest.hookimpl(trylast=True)
def pytest_sessionstart(session):
    """Let failures be named as they come where there is a terminal: not in the processes that it starts."""
    terminal = session.config.pluginmanager.getplugin("terminalreporter")
    if terminal and not hasattr(session.config, "workerinput"):
        session.config.pluginmanager.register(AtOnce(terminal))


def pytest_unconfigure(config):
    """Take the folder of grids away while all that this needs is still there."""
    CACHE.cleanup()


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
