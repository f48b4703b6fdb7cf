"""Compile CUDA sources with NVRTC, of the wheel `nvidia-cuda-nvrtc`: no GPU, no driver."""

import ctypes
from pathlib import Path

import pytest

from neve.cuda.program import WHEEL, libraries

ROOT = Path(__file__).parents[2]


def compiler():
    """Return the library of the wheel; skip where it is not installed."""
    found = libraries()
    if not found:
        pytest.skip(f"needs NVRTC: pip install {WHEEL}")
    return ctypes.CDLL(str(found[0]))


def architectures(nvrtc):
    """Return the GPU architectures that this version compiles for: 80 is sm_80."""
    count = ctypes.c_int()
    assert nvrtc.nvrtcGetNumSupportedArchs(ctypes.byref(count)) == 0
    known = (ctypes.c_int * count.value)()
    assert nvrtc.nvrtcGetSupportedArchs(known) == 0
    return set(known)


def text(nvrtc, program, what):
    """Return what NVRTC has of a program: its `ProgramLog` or `CUBIN`."""
    size = ctypes.c_size_t()
    getattr(nvrtc, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
    out = ctypes.create_string_buffer(size.value)
    getattr(nvrtc, f"nvrtcGet{what}")(program, out)
    return out.raw


def compiled(nvrtc, source, architecture):
    """Compile a source with the core's headers; return whether it was taken, the log, and the device code."""
    program = ctypes.c_void_p()
    code = source.encode()
    assert nvrtc.nvrtcCreateProgram(ctypes.byref(program), code, b"step.cu", 0, None, None) == 0
    wanted = [
        "--std=c++20",
        "--Ofast-compile=max",  # hardly optimised: seconds instead of minutes
        "--device-as-default-execution-space",
        f"--gpu-architecture=sm_{architecture}",
    ]
    options = [option.encode() for option in (*wanted, f"--include-path={ROOT / 'core'}")]
    done = nvrtc.nvrtcCompileProgram(program, len(options), (ctypes.c_char_p * len(options))(*options)) == 0
    log = text(nvrtc, program, "ProgramLog").decode().rstrip("\0")
    code = text(nvrtc, program, "CUBIN") if done else b""
    nvrtc.nvrtcDestroyProgram(ctypes.byref(program))
    return done, log, code
