"""Nothing depends on which thread comes first: a race would show in another order."""

import numpy as np
import pytest
from gpu.runs import FLOOR, advanced, assert_same, scene

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
