"""Make the height maps that come with Neve: `python tools/terrains/make_terrains.py` writes
src/neve/assets/terrains/*.png.

Each is a picture of 16 bits seen from above, x to the right and y upward. What its extent and height are
meant to be stands at the function that makes it. Needs numpy and Pillow.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.float64]

FOLDER = Path(__file__).parents[2] / "src/neve" / "assets" / "terrains"


def slope() -> Array:
    """Return a mountain side: 24 m along x, 16 m along y, 10 m from 0 to 1; heights[x, y] in [0, 1].

    It falls to +x: a rounded crest, 41 degrees, a bend, a run-out of 3 degrees; with a shallow gully in the
    middle, ribs beside it and lumps of one to three metres, which end at the edges of the map.
    """
    x, y = grid(301, 201, 24.0, 16.0)
    angle = np.radians(3.0) + np.radians(38.0) * smooth_step((x + 11.0) / 3.0) * smooth_step((3.4 - x) / 7.6)
    fall = np.cumsum(np.tan(angle[:, 0])) * (x[1, 0] - x[0, 0])
    height = (fall[-1] - fall)[:, None] * np.ones_like(y)
    height += 1.2 * smooth_step((4.5 - x) / 6.0) * (1.0 - np.exp(-((y / 3.2) ** 2)))
    rough = 0.03 + 0.04 * smooth_step((np.abs(y) - 2.4) / 1.6)
    height += rough * inland(x, y, 2.0) * lumps(x, y, 1.7, seed=5)
    return np.asarray((height - height.min()) / 10.0)


def hollow() -> Array:
    """Return a shallow hollow in level ground, longer than wide.

    Heights[x, y] in [0, 1] over a map whose sides are as 3 to 2: 0 on the floor, 0.84 on the ground
    around; the rim winds, so that snow which fills it flush ends in tongues.
    """
    x, y = grid(193, 129, 3.0, 2.0)
    radius = np.hypot(x / 1.5, y) + 0.10 * lumps(x, y, 0.55, seed=3)
    inner = inland(x, y, 0.25)
    bowl = np.maximum(smooth_step((radius - 0.50) / 0.42), 1.0 - inner)
    return np.clip(0.04 + 0.80 * bowl + 0.02 * inner * lumps(x, y, 0.2, seed=8), 0.0, 1.0)


def lane() -> Array:
    """Return a long hollow in level ground: as `hollow`, with sides as 4 to 1."""
    x, y = grid(385, 97, 4.0, 1.0)
    ends = np.maximum(np.abs(x) - 1.28, 0.0)
    radius = np.hypot(ends, np.abs(y)) + 0.045 * lumps(x, y, 0.4, seed=4)
    inner = inland(x, y, 0.06)
    bowl = np.maximum(smooth_step((radius - 0.27) / 0.20), 1.0 - inner)
    return np.clip(0.04 + 0.80 * bowl + 0.02 * inner * lumps(x, y, 0.16, seed=9), 0.0, 1.0)


def grid(nx: int, ny: int, length: float, width: float) -> tuple[Array, Array]:
    """Return x and y of the samples of a map around the origin, (nx, ny) each."""
    x, y = np.meshgrid(
        np.linspace(-0.5 * length, 0.5 * length, nx),
        np.linspace(-0.5 * width, 0.5 * width, ny),
        indexing="ij",
    )
    return x, y


def smooth_step(s: Array) -> Array:
    """Return 0 below 0, 1 above 1 and a cubic with level ends between."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s * s * (3.0 - 2.0 * s))


def inland(x: Array, y: Array, margin: float) -> Array:
    """Return 1 inside the map and 0 at its edges, so that level ground goes on beyond them."""
    inset = np.minimum(x.max() - np.abs(x), y.max() - np.abs(y))
    return smooth_step(inset / margin)


def lumps(x: Array, y: Array, size: float, seed: int) -> Array:
    """Return smooth noise of about unit height: plane waves of random direction, `size` long and shorter."""
    rng = np.random.default_rng(seed)
    total, waves = np.zeros_like(x), 48
    for k in range(waves):
        turn, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
        shrink = 3.0 ** (-k / waves)
        number = 2.0 * np.pi / (2.0 * size * shrink)
        total += shrink * np.sin(number * (x * np.cos(turn) + y * np.sin(turn)) + phase)
    return total / np.sqrt(waves / 4.0)


TERRAINS = {"slope": slope, "hollow": hollow, "lane": lane}


def make(name: str) -> NDArray[np.uint16]:
    """Return the picture of this name: rows from the top, full range 65535."""
    heights = TERRAINS[name]()
    return np.ascontiguousarray(np.rint(65535.0 * heights.T[::-1]).astype(np.uint16))


def main() -> None:
    """Write the maps named on the command line, or all."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or TERRAINS:
        picture = make(name)
        path = FOLDER / f"{name}.png"
        Image.fromarray(picture).save(path, optimize=True)
        print(f"{name}: {picture.shape[1]} x {picture.shape[0]} samples, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
