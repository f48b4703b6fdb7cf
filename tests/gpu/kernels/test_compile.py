"""The kernels compile for GPUs, and keep their numbers in registers. No GPU is needed."""

import ctypes
import subprocess
import sys

import numpy as np
import pytest

from neve import _core
from neve.cuda.layout import control_of, step_of
from neve.cuda.program import WHEEL, Choice, Compiler, compiler, libraries, usage
from neve.cuda.state import FIELDS as DEVICE_FIELDS
from neve.mpm.state import FIELDS

RESIDENT = {"g2p": 144, "p2g": 64, "grid_update": 32}
"""Most registers of a thread [1]: so that 65,536 registers hold 12, 32 and 64 warps."""
WITH_SOLIDS = {"g2p": 128, "p2g": 64, "grid_update": 96}
"""The same where there are solids: 16, 32 and 20 warps; 12 of g2p on sm_100, which may use 168 registers."""


@pytest.fixture(scope="module")
def nvrtc():
    """The compiler of the wheel; skip where it is not installed."""
    if not libraries():
        pytest.skip(f"needs NVRTC: pip install {WHEEL}")
    return compiler((1000, 0))


ALONE = """
import ctypes, sys
from neve.cuda.layout import control_of, step_of
from neve.cuda.program import Choice, compiler
choice = Choice("float32", 0, 0, 8, 1, sys.argv[2] == "solids", False, False, sys.argv[3] == "fused")
code, log = compiler((1000, 0)).compiled(choice, int(sys.argv[1]), ctypes.sizeof(step_of("float32")))
assert code.startswith(b"\\x7fELF")
print(log)
"""
"""Compiles the default step in a process of its own: NVRTC's registers depend on what it did before."""


def compiled_alone(architecture, solids, variant="usual"):
    """What the kernels of the default step need."""
    words = [str(architecture), "solids" if solids else "none", variant]
    done = subprocess.run([sys.executable, "-c", ALONE, *words], capture_output=True, text=True, check=True)
    return usage(done.stdout)


@pytest.mark.parametrize(
    ("architecture", "solids"), [(a, solids) for a in (80, 90, 100) for solids in (False, True)]
)
def test_kernels_compile(nvrtc, architecture, solids, capsys):
    """For sm_80, sm_90 and sm_100, fully optimised: nothing is spilled, and warps enough stay resident.

    What they need is printed.
    """
    needs = compiled_alone(architecture, solids)
    largest = sorted(needs.items(), key=lambda entry: -entry[1].registers)[:5]
    with capsys.disabled():
        spilled = sum(need.spilled for need in needs.values())
        used = ", ".join(f"{name} {need.registers}" for name, need in largest)
        where = "with" if solids else "without"
        print(f"\nsm_{architecture}, {where} solids: registers {used}; {spilled} B spilled in all")
    assert len(needs) == 32
    assert {name: need.spilled for name, need in needs.items() if need.spilled} == {}
    limits = WITH_SOLIDS | ({"g2p": 168} if architecture == 100 else {}) if solids else RESIDENT
    used = {name: needs[name].registers for name in limits}
    assert {name: count for name, count in used.items() if count > limits[name]} == {}
    assert all(need.shared <= 48 * 1024 for need in needs.values())


@pytest.mark.parametrize(("architecture", "most"), [(80, 128), (90, 128), (100, 168)])
def test_the_fused_kernel_compiles(nvrtc, architecture, most):
    """g2p2g with solids: nothing is spilled, and as many warps stay resident as of g2p."""
    need = compiled_alone(architecture, True, "fused")["g2p2g"]
    assert need.spilled == 0
    assert need.registers <= most
    assert need.shared <= 32 * 1024


LARGEST = {
    "all modes": ("float64", 1, 3, 27, 31, True, True, True),
    "force apart": ("float64", 1, 5, 8, 31, True, True),
    "force apart, in single": ("float32", 1, 5, 8, 31, True, True),
    "fused": ("float32", 1, 0, 8, 31, True, False, False, True),
}
"""Choices whose kernels need most of a block's shared memory."""


@pytest.mark.parametrize("name", list(LARGEST))
def test_all_that_can_be_chosen_compiles(nvrtc, monkeypatch, name):
    """With all laws, solids and play: the largest kernels. Hardly optimised, to save time."""
    usual = Compiler.options
    hasty = staticmethod(lambda *arguments: [*usual(*arguments), "--Ofast-compile=max"])
    monkeypatch.setattr(Compiler, "options", hasty)
    choice = Choice(*LARGEST[name])
    _, log = nvrtc.compiled(choice, 90, ctypes.sizeof(step_of(choice.precision)))
    assert all(need.shared <= 48 * 1024 for need in usage(log).values())


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_both_sides_know_the_same_struct(precision):
    """The structs of the kernels have the size that the core gives it."""
    core = {"float32": _core.f32, "float64": _core.f64}[precision]
    assert ctypes.sizeof(step_of(precision)) == core.device_step_bytes
    assert control_of(precision).itemsize == core.device_control_bytes


def test_every_field_has_a_column():
    """A field that the state gains has its columns on the GPU, too: sorting must not leave it behind. Snow
    does not sleep there, has no heat, and has positions of float32 alone.
    """
    state = _core.f32.State(3)
    arrays = {name for name in dir(state) if isinstance(getattr(state, name), np.ndarray)}
    assert (
        {*DEVICE_FIELDS, "rest", "enthalpy", "thermal", "beyond"}
        == arrays
        == {field.name for field in FIELDS} | {"tau"}
    )


def test_usage_is_read():
    """What the compiler says of two kernels, the second with a stack and spills."""
    log = """ptxas info    : Compiling entry function 'neve_a' for 'sm_90'
ptxas         .     0 bytes stack frame, 0 bytes spill stores, 0 bytes spill loads
ptxas info    : Used 43 registers, used 1 barriers, 8192 bytes smem
ptxas info    : Compiling entry function 'neve_b' for 'sm_90'
ptxas         .     16 bytes stack frame, 8 bytes spill stores, 4 bytes spill loads
ptxas info    : Used 32 registers
"""
    assert usage(log) == {"a": (43, 0, 0, 8192), "b": (32, 16, 12, 0)}
