"""Small runs on both devices, and how far they are from each other."""

import os

import numpy as np

import neve
from neve.scene.reading.load import scene_from

LUMP = {"shape": "box", "size": [0.2, 0.2, 0.2], "center": [0, 0, 0.12], "velocity": [1, 0.5, -4]}
WIDE = {**LUMP, "size": [0.7, 0.2, 0.2]}
"""Across several blocks."""
FLOOR = {"shape": "plane", "mu_c": 0.3, "mode": "separate"}
SECONDS = 2e-3
REAL = bool(os.environ.get("NEVE_TEST_GPU"))
"""Whether the tests that can do so run on the GPU of this machine, instead of the stand-in."""
ROOM = 1e3 if REAL else 1.0
"""How much farther apart results may be: functions and fused operations of a GPU round differently."""
FIELDS = ("x", "v", "C", "modes", "F_E", "J_P", "m", "V0", "stiffness", "strength", "material")


def scene(*colliders, source=LUMP, **numerics):
    """A lump that falls onto colliders."""
    return {
        "numerics": {"dx": 0.05, "precision": "float64", **numerics},
        "sources": [source],
        "colliders": list(colliders),
    }


def several(document, devices, **more):
    """The document, to be run on these GPUs; all of them are the first where tests run on a real one."""
    numbers = [0 if REAL else device for device in devices]
    return {**document, "numerics": {**document["numerics"], "devices": numbers, **more}}


def parts(sim):
    """How many particles each domain has."""
    return [part.count for part in sim.state.parts]


def advanced(document, device, calls=2):
    """A simulation after `calls` advances, each of which looks at the state anew."""
    document = {**document, "numerics": {**document["numerics"], "device": device}}
    sim = neve.Simulation(scene_from(document), threads=1)
    for _ in range(calls):
        sim.advance(SECONDS)
    return sim


def by_id(sim, name):
    """A field of the particles, in the order of their birth, in double."""
    return np.asarray(getattr(sim.state, name))[np.argsort(sim.state.id)].astype(float)


def assert_same(cpu, gpu, tolerance):
    """Every field, and what solids exchanged, is the same within `tolerance` of its largest value."""
    assert cpu.steps == gpu.steps
    pairs = {name: (by_id(cpu, name), by_id(gpu, name)) for name in FIELDS}
    least = {"C": np.abs(pairs["v"][0]).max() / cpu.scene.numerics.dx}  # rounding of v makes that of C
    for name, (a, b) in pairs.items():
        scale = np.abs(a).max(initial=least.get(name, 0.0))
        np.testing.assert_allclose(b, a, rtol=0, atol=ROOM * tolerance * scale, err_msg=name)
    scale = np.abs(cpu.exchanged).max(initial=1.0)
    np.testing.assert_allclose(gpu.exchanged, cpu.exchanged, rtol=0, atol=ROOM * tolerance * scale)
