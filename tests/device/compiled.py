"""Compile a C++ source of the tests with the core's headers to a library, as a user's compiler would."""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMPILER = next(
    (p for p in map(shutil.which, [os.environ.get("CXX", ""), "c++", "g++", "clang++"]) if p), None
)


def library(source, folder):
    """Return the library of a source; skip without a compiler. Warnings are errors."""
    if COMPILER is None:
        pytest.skip("needs a C++ compiler: c++, g++, clang++, or what CXX names")
    out = folder / "library.so"
    flags = ["-std=gnu++20", "-O1", "-fPIC", "-shared", "-Wall", "-Wextra", "-Wno-psabi", "-Werror"]
    command = [COMPILER, *flags, f"-I{ROOT / 'core'}", source, "-o", out]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return ctypes.CDLL(str(out))
