"""The hot loops are compiled to registers: no time is measured, the instructions are looked at.

A compiler that keeps packs in memory makes the step ten times slower and warns of nothing. The probe has each
hot loop as a function; its assembly for AVX2 and AVX-512 is read here.
"""

import os
import platform
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CMAKE = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
COMPILER = next(
    (p for p in map(shutil.which, [os.environ.get("CXX", ""), "c++", "g++", "clang++"]) if p), None
)
WIDTH = {"x86-64-v3": "y", "x86-64-v4": "z"}  # of a register: ymm, zmm

# Vector instructions that read or write the stack, in all that a function reaches: about 1.5 times what GCC
# 12.2 or Clang 14 need, whichever needs more. AVX2 has 16 registers and spills some; AVX-512 has 32.
MOST = {
    "x86-64-v3": {
        "gather<float>": 30,
        "gather<double>": 146,
        "scatter<float>": 192,
        "scatter<double>": 453,
        "fill<float>": 132,
        "fill<double>": 120,
        "node_rows<float>": 10,
        "node_rows<double>": 33,
        "return_map<float>": 1550,
        "return_map<double>": 1600,
    },
    "x86-64-v4": {
        "gather<float>": 10,
        "gather<double>": 10,
        "scatter<float>": 10,
        "scatter<double>": 20,
        "fill<float>": 10,
        "fill<double>": 10,
        "node_rows<float>": 10,
        "node_rows<double>": 10,
        "return_map<float>": 300,
        "return_map<double>": 300,
    },
}

STACK = re.compile(r"%r[sb]p\b.*\)")
VECTOR = re.compile(r"%[xyz]mm")
LANE_BY_LANE = re.compile(r"v?(sqrt|round|div|add)(ss|sd)\b")  # not mul: Clang multiplies single weights
HALF_STORE = re.compile(r"vmov(?:[ua]p[sd]|dq[ua]\d*)\s+%xmm.*\)$")  # a wider load of it then waits


def flags():
    """The flags of CMakeLists.txt that decide how the core's code is generated."""
    is_clang = "clang" in subprocess.run([COMPILER, "--version"], capture_output=True, text=True).stdout
    found = re.findall(r"(?<=[ ,])-(?:f(?!sanitize|no-omit)|mprefer)[\w=-]+", CMAKE)
    assert {"-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast"} <= set(found)
    return [flag for flag in found if not (is_clang and "sched" in flag)]


def bodies(assembly):
    """Each function of an assembly text: its symbol, and its instructions."""
    for symbol, body in re.findall(r"^([\w.$]+):[^\n]*\n(.*?)^\s*\.size\s+\1,", assembly, re.M | re.S):
        yield symbol, [line.strip() for line in body.splitlines() if re.match(r"\s+[a-z]", line)]


def reached(symbol, functions):
    """The instructions of a function and of all functions of the same text that it calls or jumps to."""
    seen, todo = {symbol}, [symbol]
    while todo:
        for line in functions[todo.pop()]:
            target = re.match(r"(?:call|jmp|callq|jmpq)\s+([\w.$]+)", line)
            if target and target[1] in functions and target[1] not in seen and ".cold" not in target[1]:
                seen.add(target[1])
                todo.append(target[1])
    return [line for name in sorted(seen) for line in functions[name]]


def stack_traffic(lines):
    """The vector instructions that read or write the stack."""
    return [line for line in lines if STACK.search(line) and VECTOR.search(line)]


@pytest.fixture(scope="module", params=list(WIDTH))
def probe(request, tmp_path_factory):
    """The level, and the instructions that each function of the probe reaches."""
    if platform.machine() not in ("x86_64", "AMD64") or COMPILER is None:
        pytest.skip("needs an x86-64 processor and a compiler (c++, or what CXX names)")
    out = tmp_path_factory.mktemp("probe") / "probe.s"
    command = [
        COMPILER,
        "-O3",
        "-std=gnu++20",
        "-w",
        *flags(),
        f"-march={request.param}",
        f"-I{ROOT / 'core'}",
    ]
    source = Path(__file__).parent / "probe.cpp"
    done = subprocess.run([*command, "-S", source, "-o", out], capture_output=True, text=True, check=False)
    if "march" in done.stderr:
        pytest.skip(f"{COMPILER} does not know -march={request.param}")
    assert done.returncode == 0, done.stderr[-2000:]
    functions = dict(bodies(out.read_text(encoding="utf-8")))
    loops = {}
    for symbol in functions:
        if name := re.match(r"_ZN4neve5probe\d+(\w+)I([fd])E", symbol):
            kind = {"f": "float", "d": "double"}[name[2]]
            loops[f"{name[1]}<{kind}>"] = reached(symbol, functions)
    return request.param, loops


def test_hot_loops_stay_in_registers(probe):
    """No more vector instructions touch the stack than the bound says."""
    level, loops = probe
    found = {name: len(stack_traffic(lines)) for name, lines in loops.items()}
    assert set(found) == set(MOST[level])
    assert {name: n for name, n in found.items() if n > MOST[level][name]} == {}


def test_hot_loops_use_whole_registers(probe):
    """Arithmetic is on registers of the machine's width, fused, nothing goes lane by lane or by halves."""
    level, loops = probe
    for name in ("gather", "scatter", "fill"):
        for kind in ("float", "double"):
            lines = loops[f"{name}<{kind}>"]
            fused = [line for line in lines if line.startswith("vf")]
            assert fused, (name, kind)
            assert all(f"%{WIDTH[level]}mm" in line for line in fused), (name, kind)
            assert [line for line in lines if LANE_BY_LANE.match(line)] == [], (name, kind)
            halves = [line for line in stack_traffic(lines) if HALF_STORE.match(line)]
            assert halves == [], (name, kind)
            if name != "scatter":  # Clang clears and moves sums by a call, once for each cell
                assert [line for line in lines if line.startswith("call")] == [], (name, kind)


STORM = """
typedef float Wide __attribute__((vector_size(64)));
struct Matrix { Wide c[3]; };
Matrix turned(Matrix a, Matrix b) {
  for (int k = 0; k < 3; ++k) a.c[k] = a.c[k] * b.c[k] + b.c[(k + 1) % 3] * a.c[(k + 2) % 3];
  return a;
}
"""


def test_a_spill_storm_is_seen(tmp_path):
    """GCC compiles vectors wider than a register through memory: the reader counts many of them."""
    if platform.machine() not in ("x86_64", "AMD64") or COMPILER is None:
        pytest.skip("needs an x86-64 processor and a compiler (c++, or what CXX names)")
    source, out = tmp_path / "storm.cpp", tmp_path / "storm.s"
    source.write_text(STORM, encoding="utf-8")
    command = [COMPILER, "-O3", "-std=gnu++20", "-w", *flags(), "-march=x86-64-v3", "-S", source, "-o", out]
    if subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip(f"{COMPILER} does not know -march=x86-64-v3")
    functions = dict(bodies(out.read_text(encoding="utf-8")))
    (symbol,) = functions
    assert (
        len(stack_traffic(functions[symbol])) > 12
    )  # 18 registers come and 6 go; the work itself needs none
