"""Every scene that comes with Neve is the same snow on both devices, a few steps of it on a coarse grid."""

import numpy as np
import pytest
from gpu.runs import by_id

import neve
from neve.scene.reading.load import load
from neve.scene.reading.presets import presets

STEPS = 6
COARSER = 2.5


def advanced_on(name, device, found):
    """A simulation of the scene after some steps that the host looks at."""
    changes = (f"numerics.dx={COARSER * found.numerics.dx}", f"numerics.device={device}", "run.film=false")
    sim = neve.Simulation(load(name, changes), threads=1)
    sim.advance(1.0, lambda: sim.steps >= STEPS)
    return sim


def on_both():
    """The presets that a GPU takes, too: material points without heat.

    Those on which it snows first take long to fill, and are snow and solids as in the others.
    """
    scenes = {name: load(name) for name in presets()}
    return [
        name
        for name, scene in scenes.items()
        if scene.numerics.method == "mpm"
        and scene.heat is None
        and not any(source.shape == "snowfall" for source in scene.sources)
    ]


@pytest.mark.gpu
@pytest.mark.parametrize("name", on_both())
def test_each_preset(some_gpu, name):
    """Within rounding of float32: 1e-4 of the largest value of each field, after the first steps."""
    found = load(name)
    cpu, gpu = (advanced_on(name, device, found) for device in ("cpu", "cuda"))
    assert (gpu.steps, gpu.count) == (cpu.steps, cpu.count)
    assert gpu.time == pytest.approx(cpu.time, rel=1e-4)
    for field in ("x", "v", "F_E", "J_P"):
        a, b = by_id(cpu, field), by_id(gpu, field)
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-4 * np.abs(a).max(), err_msg=field)
    scale = np.abs(cpu.exchanged).max(initial=1e-3)
    np.testing.assert_allclose(gpu.exchanged, cpu.exchanged, rtol=0, atol=1e-2 * scale)
