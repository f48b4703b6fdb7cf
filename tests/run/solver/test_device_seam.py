"""A second device is one class and one word: it gives the stages, and sets the number of threads."""

import numpy as np
import pytest

import neve
from neve.backend import Cpu
from neve.registry import DEVICES
from neve.scene.reading.load import scene_from


class Counting(Cpu):
    """The processor, with a list of what was asked of it."""

    asked = None

    def kernels(self, precision, deterministic=False, devices=(0,)):
        """Return the stages of the processor."""
        self.asked.append(precision)
        return super().kernels(precision, deterministic)

    def use_threads(self, count):
        """Set the threads of the processor."""
        self.asked.append(count)
        super().use_threads(count)


@pytest.fixture
def asked(monkeypatch):
    """What a registered device "counting" is asked for."""
    found = []
    monkeypatch.setitem(DEVICES.entries, "counting", Counting)
    monkeypatch.setattr(Counting, "asked", found)
    return found


def simulation(device):
    """A small ball that falls."""
    ball = {"shape": "sphere", "radius": 0.2, "center": [0, 0, 1]}
    numerics = {"device": device, "dx": 0.1, "precision": "float64"}
    return neve.Simulation(scene_from({"numerics": numerics, "sources": [ball]}), threads=1)


def test_a_registered_device_runs_the_stages(asked):
    """The stages are asked for once, in the precision of the scene; the threads before each advance."""
    sim = simulation("counting")
    assert asked.count("float64") == 1
    before = asked.count(1)
    sim.advance(0.01)
    assert (asked.count("float64"), asked.count(1)) == (1, before + 1)


def test_the_word_changes_no_bit(asked):
    """The same stages under another word give the same bits; "cpu" asks nothing of the other device."""
    other, cpu = simulation("counting"), simulation("cpu")
    other.advance(0.01)
    asked.clear()
    cpu.advance(0.01)
    assert asked == []
    np.testing.assert_array_equal(other.state.x, cpu.state.x)
