"""Describe scenes: what they may hold, how they are read, and what is doubtful about them.

    from neve.scene import Collider, Numerics, Source, scene_from, to_toml

The names below are what a program needs that describes scenes; they are loaded at their first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from neve.scene.reading.load import scene_from as scene_from
    from neve.scene.reading.load import to_toml as to_toml
    from neve.scene.schema.scene import Body as Body
    from neve.scene.schema.scene import Camera as Camera
    from neve.scene.schema.scene import Collider as Collider
    from neve.scene.schema.scene import Light as Light
    from neve.scene.schema.scene import Numerics as Numerics
    from neve.scene.schema.scene import Robot as Robot
    from neve.scene.schema.scene import Run as Run
    from neve.scene.schema.scene import Scene as Scene
    from neve.scene.schema.scene import Snow as Snow
    from neve.scene.schema.scene import Source as Source
    from neve.scene.schema.scene import World as World

_READING = ("scene_from", "to_toml")

__all__ = [
    "Body", "Camera", "Collider", "Light", "Numerics", "Robot", "Run", "Scene", "Snow", "Source", "World",
    "scene_from", "to_toml",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'neve.scene' has no attribute {name!r}")
    home = "neve.scene.reading.load" if name in _READING else "neve.scene.schema.scene"
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
