"""The stress campaign: random scenes that try to break a step, each from a seed, and what must hold."""

from neve.stress.campaign import Outcome, endure
from neve.stress.draw import draw
from neve.stress.run import run

__all__ = ["Outcome", "draw", "endure", "run"]
