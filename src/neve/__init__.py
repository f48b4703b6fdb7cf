"""Neve: a snow laboratory. Scene -> Simulation -> run folder, film and arrays.

    scene = neve.load("throw_ball")
    sim = neve.Simulation(scene)
    sim.run(out="runs/ball")

The names below are loaded at their first use: `neve --help` waits for none of them.
"""

import os

from neve.system import stopping as _stopping

if _stopping.is_command_line():  # before anything that takes long to load
    _stopping.listen()

from importlib import import_module
from typing import TYPE_CHECKING, Any

from neve.isa import extend as _extend

if TYPE_CHECKING:
    from neve.run.outputs.registry import register_output as register_output
    from neve.scene.reading.load import load as load
    from neve.scene.reading.presets import presets as presets
    from neve.scene.schema.scene import Scene as Scene
    from neve.simulation import Simulation as Simulation

# A thread that waits for the others spins for some ten microseconds, then sleeps. Where other programs
# compute too, a longer wait takes the very cores that the awaited threads need: with eight of them on two
# cores a step of 20,000 particles is ten times faster so than with 20,000 turns, and libgomp's own default
# is longer. It is read once, when the core is loaded.
os.environ.setdefault("GOMP_SPINCOUNT", "1000")

_NO_BUILD = _extend(__path__)

_HOME = {
    "Scene": "neve.scene.schema.scene",
    "load": "neve.scene.reading.load",
    "presets": "neve.scene.reading.presets",
    "Simulation": "neve.simulation",
    "register_output": "neve.run.outputs.registry",
}

__all__ = ["Scene", "Simulation", "load", "presets", "register_output"]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("neve.io.version").version()
    if name in ("_core", "_render", "_surface") and _NO_BUILD:
        raise _NO_BUILD
    if name not in _HOME:
        raise AttributeError(f"module 'neve' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
