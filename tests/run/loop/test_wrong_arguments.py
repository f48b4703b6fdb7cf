"""What Python callers hand over by mistake is one sentence that names the argument, of a fitting type."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import neve
from neve import _core, _render
from neve.fragments import Limits, find
from neve.run.loop import last_frame
from neve.scene.reading.load import scene_from

WRONG = ["x", b"x", 3, 1.5, None, {}, [], object(), True, np.zeros((2, 2))]
"""Values, of which each function takes some."""
TOOLS = Path(__file__).parents[3] / "tools"


def tiny():
    """A scene of a few particles on a plane."""
    source = {"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0.0, 0.0, 0.2]}
    return scene_from({"sources": [source], "numerics": {"dx": 0.1}, "colliders": [{"shape": "plane"}]})


@pytest.fixture(scope="module")
def sim():
    """A simulation of a few particles."""
    return neve.Simulation(tiny(), threads=1)


def fragments(**changes):
    """Find the fragments of two particles with one argument changed."""
    one = np.ones(2)
    keys = {"limits": Limits(), "spacing": 1.0} | changes
    return find(np.zeros((2, 3)), np.zeros((2, 3)), one, one, one, **keys)


CASES = {
    "scene": (neve.Simulation, WRONG, TypeError, "scene = "),
    "name_or_path": (neve.load, [w for w in WRONG if not isinstance(w, str)], TypeError, "name_or_path = "),
    "overrides": (lambda w: neve.load("throw_ball", w), ["a=1", 3, [1], {"a": 1}], TypeError, "overrides = "),
    "threads": (lambda w: neve.Simulation(tiny(), w), ["1", 1.5, True, [], {}], TypeError, "threads = "),
    "no threads": (lambda w: neve.Simulation(tiny(), w), [0, -1, 10**30], ValueError, "threads = "),
    "frames": (lambda w: last_frame(tiny(), w), ["1", 1.5, [], True], TypeError, "argument frames = "),
    "no frames": (lambda w: last_frame(tiny(), w), [0, -3], ValueError, "argument frames = "),
    "link": (
        lambda w: fragments(limits=Limits(link=w)),
        [float("inf"), float("nan"), -1.0],
        ValueError,
        "link = ",
    ),
    "spacing": (lambda w: fragments(spacing=w), ["1", None, True], TypeError, "spacing = "),
    "n": (_core.set_threads, [0, -1, 2**31 - 1], ValueError, "n: a number of threads from 1 to 1024"),
}


@pytest.mark.parametrize(("call", "values", "kind", "said"), CASES.values(), ids=CASES)
def test_functions(call, values, kind, said):
    """Each refuses each wrong value."""
    for value in values:
        with pytest.raises(kind) as caught:
            call(value)
        assert str(caught.value).startswith(said)
        assert "\n" not in str(caught.value)


def test_methods_of_a_simulation(sim):
    """advance, change, add and restore; the state stays as it was."""
    before = sim.arrays()
    for call, values, kind, said in (
        (sim.advance, ["1", None, [], {}, np.zeros(3), True], TypeError, "seconds = "),
        (sim.advance, [0, -1.0, float("nan"), float("inf"), 10**400], ValueError, "seconds = "),
        (sim.change, WRONG, TypeError, "scene = "),
        (sim.add, WRONG, TypeError, "source = "),
        (lambda w: neve.Simulation.restore(w, before), WRONG, TypeError, "scene = "),
        (lambda w: neve.Simulation.restore(tiny(), w), [3, "x", None, []], TypeError, "arrays = "),
    ):
        for value in values:
            with pytest.raises(kind, match=said) as caught:
                call(value)
            assert "\n" not in str(caught.value)
    after = sim.arrays()
    assert all(np.array_equal(before[name], after[name]) for name in before)


def test_arrays_of_the_core():
    """Levels of a density that are not there, and arrays that are none of a grid of distances."""
    snow = _render.Density(np.zeros((1, 3), np.float32), 1e-3, 0.1)
    for level in (-1, 6, 2**30):
        for call in (snow.total, snow.blocks, lambda k: snow.sample(np.zeros((1, 3), np.float32), k)):
            with pytest.raises(ValueError, match="level: from 0 to 5"):
                call(level)
    good = {
        "table": np.full((1, 1, 1), -1, np.int32),
        "coarse": np.ones((2, 2, 2, 4), np.float32),
        "fine": np.ones((0, 9, 9, 9, 4), np.float32),
        "sizes": np.ones(13),
    }
    for name in good:
        for wrong in (np.zeros(3), np.zeros((1, 1), np.int32), "x", None):
            with pytest.raises(ValueError, match=f"^{name} is not an array"):
                _core.geometry.SdfGrid.from_arrays(good | {name: wrong})
        with pytest.raises(ValueError, match=f"^{name} is not an array"):
            _core.geometry.SdfGrid.from_arrays({k: v for k, v in good.items() if k != name})


@pytest.mark.parametrize(
    "words", [["documented.py"], ["golden.py", "check", "no.json"], ["documented.py", "no", "first"]]
)
def test_tools(words):
    """A tool that is called wrongly says so, without a traceback."""
    done = subprocess.run([sys.executable, TOOLS / words[0], *words[1:]], capture_output=True, text=True)
    assert done.returncode != 0
    assert "Traceback" not in done.stderr
    assert words[0] in done.stderr
