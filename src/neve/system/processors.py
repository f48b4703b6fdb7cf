"""How many processors others leave."""

from __future__ import annotations

import os

BUSY = 0.5
"""Processors that others use, in the mean over a minute, from which on one is left to them."""


def free_threads() -> int:
    """Return how many threads a simulation that is looked at uses: all, or one less where others compute."""
    cores = os.cpu_count() or 1
    try:
        busy = os.getloadavg()[0]
    except (AttributeError, OSError):  # a system that does not say
        busy = BUSY
    return cores if busy < BUSY else max(1, cores - 1)
