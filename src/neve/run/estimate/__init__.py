"""Foresee what a run takes, before it starts: particles, steps, time, memory and disk."""

from neve.run.estimate.foresee import Estimate, Range, estimate, guess

__all__ = ["Estimate", "Range", "estimate", "guess"]
