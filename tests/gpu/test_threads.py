"""Nothing depends on which thread comes first: a race would show in another order."""

from fractions import Fraction

import numpy as np
import pytest
from gpu.runs import FIELDS, FLOOR, advanced, assert_same, scene

from neve.cuda.layout import summed

DOCUMENT = scene(FLOOR, {"shape": "sphere", "radius": 0.2, "center": [0.2, 0, 0]})


@pytest.mark.parametrize("order", [1, 2])
def test_any_order_of_threads(gpu, order):
    """Backwards and by chance: particles are sorted alike, and sums differ by rounding only."""
    forward = advanced(DOCUMENT, "cuda")
    gpu.set(order=order)
    other = advanced(DOCUMENT, "cuda")
    np.testing.assert_array_equal(other.state.id, forward.state.id)
    assert_same(forward, other, 1e-12)


def test_rows_are_in_the_order_of_blocks(gpu):
    """After a sort the rows are in the homes that they are in on the processor, one after another."""
    cpu, other = advanced(DOCUMENT, "cpu", calls=1), advanced(DOCUMENT, "cuda", calls=1)
    for sim in (cpu, other):
        sim.solver._stages.sort(anew=True)
    homes = [
        np.floor((np.asarray(sim.state.x) / 0.05 - 1.5) / 4).astype(int) for sim in (cpu, other)
    ]  # a block owns s = x / dx - 1/2 from 1 on
    np.testing.assert_array_equal(homes[0], homes[1])
    assert cpu.solver.grid.homes == other.solver.grid.homes
    assert cpu.solver.grid.blocks == other.solver.grid.blocks


CHOICES = {
    "float32": {"precision": "float32"},
    "cubic with modes": {"spline": "cubic", "transfer": "polypic", "polypic_modes": 8},
}
BODY = {"shape": "sphere", "radius": 0.06, "center": [0, 0, 0.3], "velocity": [1, 2, -5], "density": 400}


def bits(sim):
    """All that a run leaves: particles, what solids and snow exchanged, bodies, and the sums of the log."""
    arrays = {name: np.array(getattr(sim.state, name)) for name in (*FIELDS, "tau", "id")}
    totals = sim.diagnostics()
    sums = [totals.mass, *totals.momentum, totals.kinetic, totals.affine, totals.elastic, totals.potential]
    return {**arrays, "exchanged": sim.exchanged, "rigid": sim.solver.model.rigid.momentum, "sums": sums}


def in_any_order(gpu, **numerics):
    """What differs between runs of four orders of threads and blocks, and what the first of them left.

    Snow lands on a floor and a ball and meets a body: solids beyond the first few, which are summed apart.
    """
    spare = [{**FLOOR, "point": [0, 0, -k]} for k in range(1, 5)]
    mode = "slip" if "spline" in numerics else "separate"
    ball = {"shape": "sphere", "radius": 0.2, "center": [0.2, 0, 0]}
    document = {**scene({**FLOOR, "mode": mode}, *spare, ball, **numerics), "bodies": [BODY]}
    runs = []
    for order in range(4):
        gpu.set(order=order)
        runs.append(bits(advanced(document, "cuda")))
    differ = {name for run in runs for name in run if not np.array_equal(run[name], runs[0][name])}
    return differ, runs[0]


@pytest.mark.parametrize("choice", list(CHOICES))
def test_same_bits_in_any_order(gpu, choice):
    """numerics.deterministic: every bit is the same, of particles, bodies and sums."""
    differ, found = in_any_order(gpu, deterministic=True, **CHOICES[choice])
    assert differ == set()
    assert (np.abs(found["exchanged"][5:]).max(axis=1) > 0).all()  # the ball and the body were met


def test_other_bits_without_the_option(gpu):
    """So that the test above could fail."""
    differ, _ = in_any_order(gpu, **CHOICES["float32"])
    assert {"v", "sums", "exchanged"} <= differ


def test_the_option_changes_rounding_only(gpu):
    """The sums are those without it, within rounding."""
    usual = advanced(scene(FLOOR, precision="float32"), "cuda")
    assert_same(usual, advanced(scene(FLOOR, precision="float32", deterministic=True), "cuda"), 1e-5)


@pytest.mark.parametrize("numbers", [[1.0, -3.5, 2.0**-70], [1e9, 1e-9, -1e9], [2.0**61, -(2.0**61), 0.75]])
def test_sums_of_whole_numbers(numbers):
    """What `Sum` of the kernels keeps of numbers, as exact fractions of 2^-96: their exact sum."""
    parts = [0, 0, 0, 0]
    for a in numbers:
        rest = Fraction(a)
        for k in range(4):
            parts[k] += int(rest)
            rest = (rest - int(rest)) * 2**32
    raw = np.array(parts, np.int64).view(np.uint64)
    assert summed(raw, deterministic=True)[0] == float(sum(map(Fraction, numbers)))
