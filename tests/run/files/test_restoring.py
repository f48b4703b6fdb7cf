"""A checkpoint whose bytes are right and whose state is not is refused, whatever is wrong in it."""

import numpy as np
import pytest

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation

SCENE = {
    "sources": [{"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0.0, 0.0, 0.2]}],
    "numerics": {"dx": 0.1, "transfer": "polypic"},
    "bodies": [{"shape": "sphere", "radius": 0.2, "center": [0.0, 2.0, 1.0]}],
}


@pytest.fixture(scope="module")
def saved():
    """The arrays of a simulation of snow and a body after a step."""
    sim = Simulation(scene_from(SCENE), threads=1)
    sim.advance(1e-3)
    return sim.arrays()


def put(array, value, place=3):
    """A copy of the array with another value at one place."""
    changed = array.copy()
    changed.reshape(-1)[place] = value
    return changed


WRONG = {
    "a snow that is not there": ("material", lambda a: put(a, 1), "allowed is from 0 to 0"),
    "an id twice": ("id", lambda a: put(a, a[0]), "two particles have the number 0"),
    "a mode that is no number": ("modes", lambda a: put(a, np.nan), "state.modes"),
    "an inverted deformation": ("F_E", lambda a: put(a, -1.0, 0), "determinant"),
    "no mass": ("m", lambda a: put(a, 0.0), "state.m"),
    "no volume": ("V0", lambda a: put(a, -1.0), "state.V0"),
    "no particle": ("all", lambda a: a[:0], "no particle"),
    "steps before the first": ("steps", lambda a: np.int64(-1), "-1 steps"),
    "an exchange that is no number": ("exchanged", lambda a: put(a, np.inf), "exchanged"),
    "an exchange of words": ("exchanged", lambda a: a.astype(str), "exchanged"),
    "a body that is nowhere": ("engine", lambda a: put(a, np.nan), "no finite number"),
    "a body that takes no steps": ("engine", lambda a: put(a, 0.0, -1), "steps of 0 s"),
    "complex bodies": ("engine", lambda a: a + 1j, "no finite number"),
}


@pytest.mark.parametrize(("name", "change", "words"), WRONG.values(), ids=WRONG.keys())
def test_what_no_simulation_has_is_refused(saved, name, change, words):
    """One ValueError that says what is wrong, which a run turns into its sentence about the checkpoint."""
    count = len(saved["id"])
    names = [k for k, a in saved.items() if np.shape(a)[:1] == (count,)] if name == "all" else [name]
    with pytest.raises(ValueError, match=words):
        Simulation.restore(scene_from(SCENE), saved | {k: change(saved[k]) for k in names}, threads=1)


def test_what_a_simulation_has_is_restored(saved):
    """And goes on."""
    sim = Simulation.restore(scene_from(SCENE), saved, threads=1)
    sim.advance(1e-3)
    assert sim.time == pytest.approx(2e-3)
