"""The kernels on the processor: a stand-in for the driver library, compiled from their very source."""

import atexit
import ctypes
import functools
import os
import shutil
import subprocess
import tempfile
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

import pytest
from device.compiled import COMPILER, ROOT

from neve.cuda.driver import Driver

HERE = Path(__file__).parent / "shim"
MEMORY = 1 << 33


OPTIMIZED = os.environ.get("NEVE_SHIM_OPTIMIZED", "-Og")
"""How hard the compiler works: -O2 takes longer to compile, and less to run."""
FLAGS = (
    "-std=gnu++20", OPTIMIZED, "-fPIC", "-Wall", "-Wextra", "-Wno-psabi", "-Wno-unknown-pragmas", "-Werror",
)  # fmt: skip


def compiled(source, library, *flags):
    """Compile a source of the stand-in to a library; skip without a compiler."""
    if COMPILER is None:
        pytest.skip("needs a C++ compiler: c++, g++, clang++, or what CXX names")
    cached = [shutil.which("ccache")] if shutil.which("ccache") else []
    command = [*cached, COMPILER, *FLAGS, *flags, f"-I{ROOT / 'core'}", f"-I{HERE}", "-c"]
    piece = library.with_suffix(".o")
    done = subprocess.run(
        [*command, HERE / source, "-o", piece],
        capture_output=True,
        text=True,
        check=False,
        env={"CCACHE_BASEDIR": str(ROOT), "CCACHE_NOHASHDIR": "1", **os.environ},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    subprocess.run([COMPILER, "-shared", piece, "-o", library], check=True)
    return library


def build(folder):
    """Compile the stand-in, but for the kernels."""
    return compiled("driver.cpp", folder / "libcuda.so")


@functools.cache
def kernels(words):
    """Compile the kernels of a choice, at their first use."""
    folder = Path(tempfile.mkdtemp(prefix="neve-kernels-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return compiled("choice.cpp", folder / "choice.so", f"-DSHIM_CHOICE={words}")


class StandIn(Driver):
    """The stand-in as a GPU, and what only it can do."""

    def __init__(self, library, number=0, devices=1):
        ctypes.CDLL(str(library)).shim_set(ctypes.c_size_t(MEMORY), 0, 13010, devices, 0)
        super().__init__(number, str(library))
        self._devices = devices

    def set(self, memory=MEMORY, order=0, version=13010, late=0):
        """Choose its memory [bytes], the order of threads and blocks, and its driver's version.

        late: which streams work as late as they may: 0 none, 1 the lanes, 2 the usual ones
        """
        self._library.shim_set(ctypes.c_size_t(memory), order, version, self._devices, late)

    def fail(self, kernel=""):
        """Let a kernel fail, or none."""
        self._library.shim_fail(kernel.encode())

    def used(self, most=False):
        """Return how many bytes are allocated, or the most that ever were."""
        self._library.shim_used.restype = ctypes.c_size_t
        return self._library.shim_used(self.number, most)

    def graphs(self, launches=False):
        """Return how many graphs there are, or how often one was launched."""
        self._library.shim_graphs.restype = ctypes.c_size_t
        return self._library.shim_graphs(launches)

    def lanes(self):
        """Return how many streams there are beside the usual ones."""
        self._library.shim_lanes.restype = ctypes.c_size_t
        return self._library.shim_lanes()

    def overrun(self):
        """Tell whether something has been written beyond the end of an allocation."""
        self._library.shim_overrun.restype = ctypes.c_bool
        return self._library.shim_overrun()


def code_of(choice, *_):
    """Return what the stand-in loads for a choice: the kernels always have all laws, and can meet solids."""
    return str(kernels(choice._replace(laws=31, solids=True).words())).encode()


@contextmanager
def plugged_in(*stand_ins):
    """Let `numerics.device = "cuda"` find stand-ins, GPU 0, 1, ...; the first of them."""
    with (
        mock.patch("neve.cuda.backend.driver", lambda number=0: stand_ins[number]),
        mock.patch("neve.cuda.backend.compiler"),
        mock.patch("neve.cuda.model.cubin", code_of),
    ):
        yield stand_ins[0]
