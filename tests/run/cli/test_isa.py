"""The build of the core that is taken: the best that the processor runs, or the one that NEVE_ISA names."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import neve
from neve import isa
from neve.isa import IsaError, advice, carried, choose

V2, V3, V4 = "x86-64-v2", "x86-64-v3", "x86-64-v4"
ALL = ["x86-64", V2, V3, V4]


@pytest.mark.parametrize(
    ("builds", "levels", "asked", "taken"),
    [
        ([], ALL, None, None),
        ([V2, V3, V4], ALL, None, V4),
        ([V2, V3, V4], ALL[:3], None, V3),
        ([V3], ALL, None, V3),
        ([V2, V3, V4], ALL, V2, V2),
    ],
)
def test_best_build_or_the_one_asked_for(builds, levels, asked, taken):
    """The highest level that is both carried and run, unless another is named."""
    assert choose(builds, levels, asked) == taken


@pytest.mark.parametrize(
    ("builds", "levels", "asked", "words"),
    [
        ([], ALL, V3, "one build"),
        ([V3, V4], ALL, "avx2", "carries x86-64-v3, x86-64-v4"),
        ([V3, V4], ALL[:3], V4, "cannot run it; of those carried it runs x86-64-v3"),
        ([V3, V4], ALL[:2], None, "runs none of them"),
        ([V3, V4], [], None, "runs none of them"),
    ],
)
def test_no_build_is_one_sentence(builds, levels, asked, words):
    """What is not carried, or what the processor cannot run, is refused and said."""
    with pytest.raises(IsaError, match=words) as error:
        choose(builds, levels, asked)
    assert str(error.value).endswith(".")
    assert "\n" not in str(error.value)


def test_advice():
    """A processor that can do more is told of; one that cannot, or is of another kind, is not."""
    assert "pip install" in advice(V3, [], ALL)
    assert "unset NEVE_ISA" in advice(V3, [V3, V4], ALL)
    assert advice(V4, [], ALL) is None
    assert advice(V3, [], ALL[:3]) is None
    assert advice("armv8-a", [], []) is None


def test_builds_are_found_wherever_the_package_lies(tmp_path):
    """An editable install has its Python code in one folder and its builds in another."""
    (tmp_path / "site/builds" / V3).mkdir(parents=True)
    (tmp_path / "src").mkdir()
    path = [str(tmp_path / "src"), str(tmp_path / "site")]
    assert carried(path) == {V3: tmp_path / "site/builds" / V3}
    assert carried(path[:1]) == {}


def python(code, asked=None):
    """Run code in a fresh interpreter with NEVE_ISA as wished."""
    environment = {name: value for name, value in os.environ.items() if name != isa.VARIABLE}
    environment |= {isa.VARIABLE: asked} if asked else {}
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )


def test_a_wrong_wish_is_a_sentence_and_exit_code_2():
    """From the command line: no traceback. Commands that need no core work."""
    done = python("from neve.cli import main; main(['info'])", "avx9")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"neve: {isa.VARIABLE} = avx9: this copy of Neve ")
    assert done.stderr.count("\n") == 1
    assert python("from neve.cli import main; main(['list'])", "avx9").returncode == 0


def test_info_tells_the_build():
    """`neve info --json` names the instruction set of the build, and it is one that the processor has."""
    facts = json.loads(python("from neve.cli import main; main(['info', '--json'])").stdout)
    assert facts["isa"] in facts["isa_of_processor"] or not facts["isa_of_processor"]
    assert not facts["isa_carried"] or facts["isa"] in facts["isa_carried"]


SIMULATE = """
import sys, numpy as np, neve
from neve import _core
scene = neve.load("throw_ball", ["numerics.dx=0.12", "numerics.precision=PRECISION", "numerics.dt=5e-4"])
sim = neve.Simulation(scene)
sim.advance(0.05)
rows = np.argsort(sim.state.id)
np.savez(sys.argv[1], x=sim.state.x[rows], v=sim.state.v[rows], F_E=sim.state.F_E[rows])
"""


RUNS = sorted(set(carried(neve.__path__)) & set(isa.processor()))


@pytest.mark.skipif(len(RUNS) < 2, reason="one build alone: nothing to compare")
@pytest.mark.parametrize(("precision", "tolerance"), [("float32", 2e-4), ("float64", 1e-11)])
def test_instruction_sets_agree(tmp_path, precision, tolerance):
    """Builds round differently (fused products, the estimate of 1/sqrt), and the differences grow: after 100
    steps each field agrees within this part of its largest value."""
    found = {}
    for name in RUNS:
        path = tmp_path / f"{name}.npz"
        code = SIMULATE.replace("PRECISION", precision).replace("sys.argv[1]", repr(str(path)))
        assert python(code, name).returncode == 0
        found[name] = np.load(path)
    first = found.pop(min(found))
    for other in found.values():
        for field in first.files:
            scale = np.abs(first[field]).max()
            np.testing.assert_allclose(other[field], first[field], rtol=0, atol=tolerance * scale)
