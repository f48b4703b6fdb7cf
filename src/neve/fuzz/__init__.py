"""Random scenes that try to break a step, each from a seed, and what must hold for them."""

from neve.fuzz.campaign import Outcome, endure
from neve.fuzz.draw import draw
from neve.fuzz.run import run

__all__ = ["Outcome", "draw", "endure", "run"]
