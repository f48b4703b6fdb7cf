"""Try the sentence that each named snow has in docs/snows.md at other sizes, speeds and resolutions.

python examples/studies/snow_sentences.py [KIND]... [--threads N]  # the figures behind docs/snows.md; minutes

A ball of diameter D is thrown onto hard ground at 59 degrees; the avalanche snows are a block of 8 m x 8 m x
4 m on a slope of 35 degrees. What holds is a limit on what is measured, one for each snow, in HOLDS.
"""

from __future__ import annotations

import argparse
import math
import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from neve.fragments import find
from neve.scene import Scene, scene_from
from neve.simulation import Simulation

SIZES, SPEEDS = (0.2, 0.5, 1.2), (3.0, 6.0, 12.0)
"""Diameters [m] and speeds [m/s]."""
CELLS = {"packed": 16}
"""Cells to a diameter, of a snow whose lumps ten cells do not resolve."""
STEEP = math.radians(59.0)
BLOCK = (8.0, 8.0, 4.0)
SLOPE = math.radians(35.0)


class Landed(NamedTuple):
    """Say how snow lies after a throw, in diameters, or after a slide, in lengths of the block.

    high: below which 98 % of the snow lies. wide: standard deviation of the places, mean of x and y (of a
    ball at rest 0.22), or along the slope (of the block 0.29). largest, powder: shares of the mass [1].
    pieces: fragments [1]
    """

    high: float
    wide: float
    largest: float
    powder: float
    pieces: int


HOLDS: dict[str, tuple[str, Callable[[Landed], bool]]] = {
    "reference": ("in three pieces or more", lambda s: s.pieces >= 3),
    "powder": ("lies flat or is dust", lambda s: s.high < 0.36 or s.powder > 0.9),
    "fresh": ("flattened, and crumbs of 1 to 40 %", lambda s: s.high < 0.6 and 0.6 < s.largest < 0.99),
    "packed": (
        "a largest lump of 10 to 75 %, more pieces, 15 % crumbs",
        lambda s: 0.1 < s.largest < 0.75 and s.pieces >= 2 and s.powder > 0.15,
    ),
    "wet": ("one piece, dented", lambda s: s.largest > 0.98 and s.wide < 0.36 and s.high < 0.97),
    "slush": ("flat and wide", lambda s: s.high < 0.25 and s.wide > 0.55),
    "icy": ("rebounds, 60 % in one piece", lambda s: s.high > 0.7 and s.largest > 0.6),
    "crust": ("broken: no piece of 75 %", lambda s: s.largest < 0.75),
    "muddy": (
        "one piece, smeared",
        lambda s: s.largest > 0.98 and s.high < 0.5 and 0.3 < s.wide < 0.65,
    ),
}
"""Snow -> what was taken for its sentence, in words and as a test."""
SLIDES: dict[str, tuple[str, Callable[[Landed], bool]]] = {
    "cold_dense": ("spreads", lambda s: s.wide > 0.5),
    "warm_shear": ("in pieces", lambda s: s.pieces >= 5),
    "sliding_slab": ("whole blocks", lambda s: s.high > 0.5),
    "warm_plug": ("one mass", lambda s: s.largest > 0.9),
    "vallee_de_la_sionne": ("spreads", lambda s: s.wide > 0.5),
}
"""The same of avalanche snows on a slope."""


def thrown(kind: str, size: float, speed: float, cells: float, threads: int | None = 1) -> Landed:
    """Throw a ball of `size` [m] at `speed` [m/s], and look 0.45 sqrt(size / 0.5 m) s after it hits."""
    dx = size / cells
    scene = scene_from(
        {
            "numerics": {"dx": dx},
            "snow": {"kind": kind},
            "sources": [
                {
                    "shape": "sphere",
                    "center": [-0.6 * size, 0.0, 0.7 * size],
                    "radius": 0.5 * size,
                    "velocity": [speed * math.cos(STEEP), 0.0, -speed * math.sin(STEEP)],
                }
            ],
            "colliders": [{"shape": "plane", "mu_c": 0.6}],
        }
    )
    x, mass, pieces = _after(scene, 0.2 * size / speed + 0.45 * math.sqrt(size / 0.5), threads)
    high, wide = np.percentile(x[:, 2], 98) / size, x[:, :2].std(axis=0).mean() / size
    return Landed(float(high), float(wide), float(mass[1:2].sum()), float(mass[0]), pieces)


def slid(kind: str, dx: float, threads: int | None = 1) -> Landed:
    """Let a block slide down a slope for four seconds; gravity is turned instead of the ground."""
    length, width, depth = BLOCK
    scene = scene_from(
        {
            "world": {"gravity": [9.81 * math.sin(SLOPE), 0.0, -9.81 * math.cos(SLOPE)]},
            "numerics": {"dx": dx},
            "snow": {"kind": kind},
            "sources": [{"shape": "box", "center": [0.0, 0.0, 0.5 * depth], "size": [length, width, depth]}],
            "colliders": [{"shape": "plane", "mu_c": 0.4}],
        }
    )
    x, mass, pieces = _after(scene, 4.0, threads)
    high, wide = np.percentile(x[:, 2], 98) / depth, x[:, 0].std() / length
    return Landed(float(high), float(wide), float(mass[1:2].sum()), float(mass[0]), pieces)


def _after(scene: Scene, seconds: float, threads: int | None) -> tuple[np.ndarray, np.ndarray, int]:
    """Return places [m], shares of the mass of powder and fragments, and the number of fragments."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sim = Simulation(scene, threads=threads)
        sim.advance(seconds)
    s = sim.state
    found = find(s.x, s.v, s.J_P, s.m, s.V0, scene.numerics.spacing)
    return np.asarray(s.x, float), found.mass / found.mass.sum(), found.count


def table(kinds: list[str], threads: int | None) -> None:
    """Print a row for each throw or slide: what was measured, and whether the sentence holds."""
    print("| snow | D [m] | speed [m/s] | D / dx | high | wide | largest | powder | pieces | holds |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for kind in kinds:
        if kind in SLIDES:
            _row(f"| `{kind}` | slope | | dx 1 m", slid(kind, 1.0, threads), SLIDES[kind][1])
            continue
        cells = CELLS.get(kind, 10)
        tried = [(size, speed, cells) for size in SIZES for speed in SPEEDS]
        for size, speed, fine in [*tried, (0.5, 6.0, 16)]:
            landed = thrown(kind, size, speed, fine, threads)
            _row(f"| `{kind}` | {size:g} | {speed:g} | {fine}", landed, HOLDS[kind][1])


def _row(start: str, s: Landed, holds: Callable[[Landed], bool]) -> None:
    shares = f"{s.largest:.0%} | {s.powder:.0%}"
    word = "yes" if holds(s) else "no"
    print(f"{start} | {s.high:.2f} | {s.wide:.2f} | {shares} | {s.pieces} | {word} |", flush=True)


def main() -> None:
    """Read the command line and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=", ".join([*HOLDS, *SLIDES]))
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    table(options.kinds or [*HOLDS, *SLIDES], options.threads)


if __name__ == "__main__":
    main()
