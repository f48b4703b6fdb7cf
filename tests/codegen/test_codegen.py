"""The hot loops are compiled to registers: no time is measured, the instructions are looked at.

A compiler that keeps packs in memory makes the step ten times slower and warns of nothing. The probe has each
hot loop as a function; its assembly for AVX2 and AVX-512 is read here. Linux on x86-64 alone.
"""

import functools
import os
import platform
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from assembly import calls, counts, functions, reached

ROOT = Path(__file__).parents[2]
CMAKE = re.sub(r"#.*", "", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))
COMPILER = next(
    (p for p in map(shutil.which, [os.environ.get("CXX", ""), "c++", "g++", "clang++"]) if p), None
)

# Vector instructions that read or write the stack, in all that a function reaches: what GCC 12.2 and what
# Clang 14 need (None: not counted). Each is counted as it stands in the text, a loop's body once, so the
# number is that of one particle (scatter: and of leaving a cell), one pack (fill, return_map), or one row of
# nodes (node_rows). AVX2 has 16 registers and spills some; AVX-512 has 32.
TODAY = {
    "x86-64-v3": {
        "gather<float>": (2, None),
        "gather<double>": (11, None),
        "scatter<float>": (4, None),
        "scatter<double>": (20, None),
        "fill<float>": (2, None),
        "fill<double>": (0, None),
        "node_rows<float>": (0, 0),
        "node_rows<double>": (22, 12),
        "return_map<float>": (298, None),
        "return_map<double>": (305, None),
    },
    "x86-64-v4": {
        "gather<float>": (0, 0),
        "gather<double>": (6, 0),
        "scatter<float>": (0, None),
        "scatter<double>": (0, None),
        "fill<float>": (0, 0),
        "fill<double>": (0, 0),
        "node_rows<float>": (0, 0),
        "node_rows<double>": (0, 0),
        "return_map<float>": (208, 175),
        "return_map<double>": (207, 190),
    },
}
# The most that another compiler may need: 1.5 times as many, and 8 more where there are few. When packs were
# wider than a register, GCC for AVX2 needed 2.4 (scatter<double>) to 19 (gather<float>) times as many.
LEEWAY, SPARE = 1.5, 8

# The most of what else `counts` counts; of what is not named here there is none.
ALLOWED = {
    "gather<double>": {"scalar": 8},  # AVX2: the weights of four nodes, each made ready once
    "node_rows<double>": {"scalar": 4},  # Clang, AVX2: a node is one register, and 1 / m of it one number
    # scalar, narrow: the law's constants, outside the loop; halves: Clang's 9, here 1.5 times as many
    "return_map<float>": {"scalar": 11, "narrow": 3, "halves": 14},
    "return_map<double>": {"scalar": 11, "narrow": 3, "halves": 14},
}
# Calls out of the probe, the most of each: Clang copies a result of the law by call.
ALLOWED_CALLS = {
    "return_map<float>": {"memcpy": 1},
    "return_map<double>": {"memcpy": 1},
}


@functools.cache
def is_clang():
    """Say whether the compiler at hand is Clang."""
    said = subprocess.run([COMPILER, "--version"], capture_output=True, text=True, check=True).stdout
    return "clang" in said


@functools.cache
def is_measured():
    """Say whether the compiler at hand is one whose numbers stand here: others spill as they think best."""
    said = subprocess.run([COMPILER, "-dumpversion"], capture_output=True, text=True, check=True).stdout
    return said.partition(".")[0].strip() == ("14" if is_clang() else "12")


def flags(clang):
    """The flags of CMakeLists.txt that decide how the core's code is generated."""
    gnu = r'if\(CMAKE_CXX_COMPILER_ID STREQUAL "GNU"\).*?endif\(\)'
    text = re.sub(gnu, "", CMAKE, flags=re.S) if clang else CMAKE
    found = re.findall(r"(?<=[ ,:])-(?:O3|f(?!sanitize|no-omit)|m(?:prefer|move|store|mem))[\w=:,-]*", text)
    return ["-std=gnu++20", "-w", "-Wno-psabi", *found]


def compiled(source, level, folder):
    """Compile to assembly and return its functions; skip where that cannot be."""
    if platform.machine() not in ("x86_64", "AMD64") or platform.system() != "Linux":
        pytest.skip("the instructions are read on Linux on x86-64 alone")
    if COMPILER is None:
        pytest.skip("needs a C++ compiler: c++, g++, clang++, or what CXX names")
    out = folder / "out.s"
    command = [COMPILER, *flags(is_clang()), f"-march={level}", f"-I{ROOT / 'core'}", "-S", source, "-o", out]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode and re.search(r"march|unknown target CPU", done.stderr):
        pytest.skip(f"{COMPILER} is too old: it does not know -march={level}")
    assert done.returncode == 0, done.stderr[-2000:]
    return functions(out.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def compile_probe(tmp_path_factory):
    """Compile the probe for a level, once, whatever the order of the tests."""
    source = Path(__file__).parent / "probe.cpp"
    return functools.cache(lambda level: compiled(source, level, tmp_path_factory.mktemp("probe")))


@pytest.fixture(params=list(TODAY))
def probe(request, compile_probe):
    """The level, and the instructions that each function of the probe reaches."""
    of, loops = compile_probe(request.param), {}
    if not is_measured():
        pytest.skip("the bounds are those of GCC 12 and Clang 14")
    for symbol in of:
        if name := re.match(r"_ZN4neve5probe\d+(\w+?)I([fd])E", symbol):
            kind = {"f": "float", "d": "double"}[name[2]]
            loops[f"{name[1]}<{kind}>"] = reached(symbol, of)
    return request.param, loops


def test_flags_are_those_of_the_build():
    """The flags are read from CMakeLists.txt, of its comments none."""
    some = {"-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast", "-mprefer-vector-width=512"}
    gcc = {"-fschedule-insns", "-fsched-pressure", "-mmove-max=512", "-mstore-max=512"}
    gcc |= {f"-mmem{what}-strategy=vector_loop:8192:noalign,libcall:-1:noalign" for what in ("cpy", "set")}
    given = {"-std=gnu++20", "-w", "-Wno-psabi"}
    assert set(flags(clang=False)) == given | some | gcc
    assert set(flags(clang=True)) == given | some


def test_hot_loops_stay_in_registers(probe):
    """No more vector instructions touch the stack than the bound says."""
    level, loops = probe
    assert set(loops) == set(TODAY[level])
    needs = {name: today[is_clang()] for name, today in TODAY[level].items()}
    bound = {name: LEEWAY * n + SPARE for name, n in needs.items() if n is not None}
    found = {name: counts(loops[name], level)["stack"] for name in bound}
    assert {name: f"{n} > {bound[name]}" for name, n in found.items() if n > bound[name]} == {}


def test_hot_loops_use_whole_registers(probe):
    """Multiply-adds are fused, packs fill registers, and nothing goes lane by lane or by halves."""
    level, loops = probe
    for name, lines in loops.items():
        found = counts(lines, level)
        assert found["fused"] > 0, name
        allowed = ALLOWED.get(name, {})
        most = {kind: allowed.get(kind, 0) for kind in ("halves", "strings", "scalar", "narrow")}
        assert {kind: found[kind] for kind in most if found[kind] > most[kind]} == {}, name


def test_hot_loops_call_nothing(probe):
    """No loop copies by memcpy or leaves the probe, but where the table says so."""
    _, loops = probe
    for name, lines in loops.items():
        out = {to: n for to, n in calls(lines).items() if not re.match(r"_ZNK?4neve", to)}
        most = ALLOWED_CALLS.get(name, {})
        assert {to: n for to, n in out.items() if n > most.get(to, 0)} == {}, name


# The same sums of the same numbers: in vectors wider than a register and by calls; in registers and inlined.
STORM = """
template <int bytes> struct Matrix { typedef float Pack __attribute__((vector_size(bytes))); Pack c[3]; };
template <class M> [[gnu::always_inline]] inline M turned_here(M a, M b) {
  return {{a.c[0] * b.c[0] + b.c[1], a.c[1] * b.c[1] + b.c[2], a.c[2] * b.c[2] + b.c[0]}};
}
[[gnu::noinline]] Matrix<64> turned(Matrix<64> a, Matrix<64> b) { return turned_here(a, b); }
extern "C" void storm(Matrix<64>* m, int n) {
  for (int i = 0; i < n; ++i) m[i] = turned(turned(m[i], m[i]), m[i]);
}
extern "C" void calm(Matrix<32>* m, int n) {
  for (int i = 0; i < 2 * n; ++i) m[i] = turned_here(turned_here(m[i], m[i]), m[i]);
}
"""


def test_a_spill_storm_is_seen(tmp_path):
    """Vectors wider than a register go through memory, and are counted; the same work in registers is not."""
    source = tmp_path / "storm.cpp"
    source.write_text(STORM, encoding="utf-8")
    of = compiled(source, "x86-64-v3", tmp_path)
    storm, calm = (counts(reached(name, of), "x86-64-v3") for name in ("storm", "calm"))
    assert calm["stack"] == 0
    assert calm["fused"] > 0
    # each call is given 12 registers and gives back 6; written, read, and read again by who called
    assert storm["stack"] > LEEWAY * calm["stack"] + SPARE + 12


TEXT = """
hot:
\tpushq\t%rbp
\tmovq\t%rsp, %rbp
\tvmovdqa\t%xmm0, -64(%rbp)  # 16-byte Spill
\tvmovaps\t-64(%rbp), %ymm1
\tvaddss\t(%rdi), %xmm0, %xmm0
\tvmulps\t%xmm0, %xmm1, %xmm2
\trep movsq
.L3:
\tvfmadd231ps\t32(%rsp), %ymm1, %ymm2
\tcall\tmemcpy@PLT
\tjmp\thelper
\t.size\thot, .-hot
helper:
\tvmovaps\t(%rbp), %ymm0
\tjne\t.L3
\tcall\trare
\t.size\thelper, .-helper
\t.section\t.text.unlikely
rare:
\tvmovaps\t%ymm0, (%rsp)
\t.size\trare, .-rare
"""


def test_assembly_is_read():
    """The reader follows calls and jumps, knows the stack, leaves out the unlikely, and sees each fault."""
    lines = reached("hot", functions(TEXT))
    assert counts(lines, "x86-64-v3") == {
        "stack": 3,
        "halves": 1,
        "strings": 1,
        "scalar": 1,
        "narrow": 1,
        "fused": 1,
    }
    assert counts(lines, "x86-64-v4")["narrow"] == 2  # the fused one is of ymm
    assert calls(lines) == {"memcpy": 1, "rare": 1}
