"""How many frames are drawn at once when nobody says."""

from __future__ import annotations

from neve.system import memory

BASE, GRAIN, PIXEL = 3e8, 220.0, 600.0
"""Memory of a process [bytes]: at all, for each grain, for each pixel. Measured: 0.60 GB with 1.6 million
grains at 640x360, 1.88 GB with 7.9 million at 1280x720."""
WORTH = 1_000_000
"""Paths of light for which another process is worth its start."""


def needed(grains: int, pixels: int) -> float:
    """Return about how much memory a process takes that draws so many grains and pixels [bytes]."""
    return BASE + GRAIN * grains + PIXEL * pixels


def jobs_for(frames: int, cores: int, paths: int, size: float) -> int:
    """Return how many frames to draw at once: one on each core, as far as the memory that is free allows.

    Making the geometry of a frame and loading it uses few cores at a time, so that frames side by side are
    faster than one after the other. frames: to be drawn; paths: of light in all of them; size: memory of a
    process [bytes]
    """
    left = memory.free()
    fits = frames if left is None else int(memory.RESERVE * left / size)
    return max(1, min(frames, cores, fits, paths // WORTH))
