"""Measure how much a film flickers: differences of successive pictures, by how far the snow moved.

    neve render RUN --quality draft
    python examples/studies/flicker.py RUN [--pictures RUN/render]

For each pair of successive pictures, the mean difference in grey levels (of 255) over the pixels in which no
snow is near, and over those that show snow which moves by so many pixels: of all snow within four pixels,
that which moves furthest. Snow that stands still must not change; that which moves changes, of course.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import maximum_filter

from neve.io.frames import read_frame
from neve.io.run_folder import RunFolder
from neve.render.path_tracing.lens import Lens
from neve.render.shot import opening
from neve.scene.reading.load import load

MOTIONS = [0.0, 0.03, 0.1, 0.3, 1.0, 3.0, 1e9]
"""Edges of the classes of motion [px]."""
NEAR = 4
"""Distance within which snow counts [px]."""


def moved(lens: Lens, folder: Path, a: int, b: int) -> np.ndarray:
    """Return how far the snow near each pixel moves between frames a and b [px], -1 where there is none."""
    first, second = read_frame(folder, a), read_frame(folder, b)
    _, here, there = np.intersect1d(first.id, second.id, return_indices=True)
    ends = [lens.project(x)[:2] for x in (first.x[here], second.x[there])]
    far = np.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1])
    grid = np.full((lens.height, lens.width), -1.0)
    for column, row in ends:
        seen = (column >= 0) & (row >= 0) & (column < lens.width) & (row < lens.height)
        np.maximum.at(grid, (row[seen].astype(int), column[seen].astype(int)), far[seen])
    return maximum_filter(grid, 2 * NEAR + 1)


def main() -> None:
    """Read the command line and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("run", type=Path)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    run = RunFolder(options.run)
    scene = load(run.path)
    if scene.camera.follow or scene.camera.turntable or len(scene.camera.keyframes) > 1:
        raise SystemExit(f"{run.path}: its camera moves, so that every pixel changes.")
    pictures = options.pictures or run.path / "render"
    numbers = sorted(int(path.stem) for path in pictures.glob("[0-9]*.png"))
    total, count = np.zeros(len(MOTIONS)), np.zeros(len(MOTIONS))
    for a, b in pairwise(numbers):
        one, two = (np.asarray(Image.open(pictures / f"{n:06d}.png"), np.float64) for n in (a, b))
        change = np.abs(two - one).mean(axis=2)
        motion = moved(Lens(opening(scene.camera), one.shape[1], one.shape[0]), run.frames, a, b)
        which = np.digitize(motion, MOTIONS)
        total += np.bincount(which.ravel(), change.ravel(), len(MOTIONS))
        count += np.bincount(which.ravel(), minlength=len(MOTIONS))
    print(f"{len(numbers)} pictures")
    print("| snow moves by [px] | pixels of a picture | change [grey levels] |")
    print("|---|---|---|")
    names = [
        "no snow near",
        *(f"{low:g} to {high:g}" if high < 1e9 else f"over {low:g}" for low, high in pairwise(MOTIONS)),
    ]
    for name, sum_, n in zip(names, total, count, strict=True):
        print(f"| {name} | {n / max(len(numbers) - 1, 1):.0f} | {sum_ / max(n, 1):.2f} |")


if __name__ == "__main__":
    main()
