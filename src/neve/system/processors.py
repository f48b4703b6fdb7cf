"""How many processors there are for this process, and how many others leave."""

from __future__ import annotations

import os

BUSY = 0.5
"""Processors that others use, in the mean over a minute, from which on one is left to them."""


def cores() -> int:
    """Return how many cores this process may use: of an allocation, or of a binding, those alone."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def free_threads() -> int:
    """Return how many threads a simulation that is looked at uses: all, or one less where others compute."""
    cores = os.cpu_count() or 1
    try:
        busy = os.getloadavg()[0]
    except (AttributeError, OSError):  # a system that does not say
        busy = BUSY
    return cores if busy < BUSY else max(1, cores - 1)
