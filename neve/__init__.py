"""Neve: a snow laboratory. Scene -> Simulation -> run folder, film and arrays.

scene = neve.load("throw_ball")
sim = neve.Simulation(scene)
sim.run(out="runs/ball")
"""

import os

# A thread that waits for the others spins for some 50 microseconds, then sleeps: on a busy machine the
# default of libgomp, to spin for milliseconds, takes the very cores that the awaited threads need. It is
# read once, when the core is loaded.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

from importlib.metadata import PackageNotFoundError, version

from neve.scene.load import load, presets
from neve.scene.scene import Scene
from neve.simulation import Simulation

try:
    __version__ = version("neve")
except PackageNotFoundError:  # a source tree that is not installed
    __version__ = "0+source"

__all__ = ["Scene", "Simulation", "__version__", "load", "presets"]
