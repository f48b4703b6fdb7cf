"""Random scenes that try to break a step, and what must hold for them."""

from neve.fuzz.scenes.draw import draw
from neve.fuzz.scenes.trial import endure

__all__ = ["draw", "endure"]
