"""Compile the kernels with NVRTC at their first use, and keep the machine code.

What is kept is named by a hash of all sources, the choice, the architecture and the compiler, in the folder
of `neve.geometry.cache`.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib.util
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from neve.cuda.errors import DeviceError, NoDevice
from neve.geometry import cache

FOLDERS = ("math", "constitutive", "transfer", "geometry", "coupling", "mpm", "cuda")
"""Folders of the core that device code is made of."""
WHEEL = "nvidia-cuda-nvrtc"
"""What brings the compiler: `pip install nvidia-cuda-nvrtc`."""


class Choice(NamedTuple):
    """What kernels are compiled for, as `Choice` in `core/cuda/choices.hpp`."""

    precision: str
    spline: int
    transfer: int
    modes: int
    laws: int
    solids: bool
    play: bool
    deterministic: bool = False
    fused: bool = False

    def words(self) -> str:
        """Return the arguments of the template."""
        real = "float" if self.precision == "float32" else "double"
        flags = ", ".join(
            "true" if flag else "false" for flag in (self.solids, self.play, self.deterministic, self.fused)
        )
        return f"{real}, {self.spline}, {self.transfer}, {self.modes}, {self.laws}u, {flags}"


@functools.cache
def sources() -> Path:
    """Return the folder of the core's sources: of the package, or of the checkout that it is run from."""
    import neve

    inside = [Path(folder) / "core" for folder in neve.__path__]
    for folder in (Path(__file__).parents[3] / "core", *inside):
        if (folder / "cuda" / "kernels.cu").is_file():
            return folder
    raise DeviceError("the sources of the kernels are not there: install Neve anew")


def _text() -> bytes:
    """Return all that the kernels are made of."""
    files = [path for folder in FOLDERS for path in sorted((sources() / folder).rglob("*.[hc]*"))]
    return b"\0".join(path.name.encode() + b"\0" + path.read_bytes() for path in files)


class Compiler:
    """NVRTC, of the newest wheel that is not newer than the driver."""

    def __init__(self, library: Path) -> None:
        self._library = ctypes.CDLL(str(library))
        major, minor = ctypes.c_int(), ctypes.c_int()
        self._library.nvrtcVersion(ctypes.byref(major), ctypes.byref(minor))
        self.version = (major.value, minor.value)

    def compiled(self, choice: Choice, architecture: int, step_bytes: int) -> tuple[bytes, str]:
        """Return the machine code of the kernels, and what the compiler said of them. Errors: DeviceError."""
        program = ctypes.c_void_p()
        text = (sources() / "cuda" / "kernels.cu").read_bytes()
        self._library.nvrtcCreateProgram(ctypes.byref(program), text, b"kernels.cu", 0, None, None)
        try:
            options = [option.encode() for option in self.options(choice, architecture, step_bytes)]
            taken = self._library.nvrtcCompileProgram(
                program, len(options), (ctypes.c_char_p * len(options))(*options)
            )
            log = self._text(program, "ProgramLog").decode(errors="replace").rstrip("\0")
            if taken != 0:
                raise DeviceError(f"the kernels do not compile for sm_{architecture}: {log[:400]}")
            return self._text(program, "CUBIN"), log
        finally:
            self._library.nvrtcDestroyProgram(ctypes.byref(program))

    @staticmethod
    def options(choice: Choice, architecture: int, step_bytes: int) -> list[str]:
        """Return what the compiler is asked for."""
        return [
            "--std=c++20",
            "--device-as-default-execution-space",
            "--ptxas-options=--verbose",
            f"--gpu-architecture=sm_{architecture}",
            f"--include-path={sources()}",
            f"--define-macro=NEVE_CHOICE={choice.words()}",
            f"--define-macro=NEVE_STEP_BYTES={step_bytes}",
        ]

    def _text(self, program: ctypes.c_void_p, what: str) -> bytes:
        size = ctypes.c_size_t()
        getattr(self._library, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
        out = ctypes.create_string_buffer(size.value)
        getattr(self._library, f"nvrtcGet{what}")(program, out)
        return out.raw


class Usage(NamedTuple):
    """What a kernel needs: registers of a thread, bytes of its stack and of its spilled registers, and
    bytes of shared memory of a block.
    """

    registers: int
    stack: int
    spilled: int
    shared: int


def usage(log: str) -> dict[str, Usage]:
    """Return what each kernel needs, from what the compiler said of the machine code (ptxas --verbose)."""
    found = {}
    for part in log.split("Compiling entry function ")[1:]:
        name = part.partition("'")[2].partition("'")[0].removeprefix("neve_")

        def number(pattern: str, part: str = part) -> int:
            match = re.search(rf"(\d+) {pattern}", part)
            return int(match[1]) if match else 0

        registers = re.search(r"Used (\d+) registers", part)
        spilled = number("bytes spill stores") + number("bytes spill loads")
        found[name] = Usage(
            int(registers[1]) if registers else 0, number("bytes stack frame"), spilled, number("bytes smem")
        )
    return found


def libraries() -> list[Path]:
    """Return the NVRTC libraries of the wheels that are installed."""
    pattern = "nvrtc64_*.dll" if sys.platform == "win32" else "libnvrtc.so.*"
    spec = importlib.util.find_spec("nvidia")  # wherever Python finds packages, PYTHONPATH included
    folders = spec.submodule_search_locations if spec else None
    found = [path for folder in folders or () for path in sorted(Path(folder).glob(f"**/{pattern}"))]
    return [path for path in found if "alt" not in path.name]


def compiler(newest: tuple[int, int]) -> Compiler:
    """Return the compiler to use with a driver that knows CUDA up to `newest`. Errors: NoDevice."""
    found = [Compiler(path) for path in libraries()]
    if not found:
        raise NoDevice(f"there is no compiler for it: pip install {WHEEL}")
    fit = [each for each in found if each.version[0] <= newest[0]]
    if not fit:
        raise NoDevice(
            f"its driver is too old: it knows CUDA {newest[0]}.{newest[1]}, and the compiler is of "
            f"{found[0].version[0]}.{found[0].version[1]}; update the driver, or install "
            f"{WHEEL}-cu{newest[0]}"
        )
    return max(fit, key=lambda each: each.version)


def cubin(choice: Choice, architecture: int, newest: tuple[int, int], step_bytes: int) -> bytes:
    """Return the machine code of the kernels, compiled or kept. Errors: NoDevice, DeviceError."""
    made_by = compiler(newest)
    key = hashlib.sha256(_text())
    options = made_by.options(choice, architecture, step_bytes)
    key.update(repr((made_by.version, [o for o in options if "include-path" not in o])).encode())
    name = f"cubin-{key.hexdigest()[:32]}"
    kept: dict[str, Any] | None = cache.recall(name)
    if kept is not None and "code" in kept:
        return bytes(kept["code"].tobytes())
    code, _ = made_by.compiled(choice, architecture, step_bytes)
    cache.keep(name, {"code": np.frombuffer(code, dtype=np.uint8)})
    return code
