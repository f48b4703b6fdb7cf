"""Throw the same snowball in every kind of snow and put the pictures on one sheet: docs/images/snows.jpg.

python examples/studies/snows.py [--out FILE] [--kinds powder icy] [--dx 0.036] [--threads N]
"""

from __future__ import annotations

import argparse
from importlib import resources
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from neve.render.preview import Preview
from neve.scene import Scene, scene_from
from neve.scene.schema.snow_kinds import SNOWS
from neve.simulation import Simulation

MOMENTS = (0.17, 0.6)  # soon after the impact, and at rest or nearly so [s]
CELL = (256, 200)  # of one picture [px]
COLUMNS = 4


def scene(kind: str, dx: float) -> Scene:
    """Return the snowball of `kind`: half a metre across, thrown down at 6 m/s onto hard ground."""
    return scene_from(
        {
            "numerics": {"dx": dx},
            "snow": {"kind": kind},
            "sources": [
                {
                    "shape": "sphere",
                    "center": [-0.35, 0.0, 0.75],
                    "radius": 0.25,
                    "velocity": [2.5, 0.0, -5.5],
                    "spin": [0.0, 4.0, 0.0],
                }
            ],
            "colliders": [{"shape": "plane", "mu_c": 0.6}],
            "camera": {"position": [0.9, -2.5, 0.62], "target": [0.1, 0.0, 0.22], "fov": 27.0},
            "light": {"sun_elevation": 26.0, "sun_azimuth": 210.0, "sun_color": [1.0, 0.88, 0.72]},
        }
    )


def pictures(kind: str, dx: float, threads: int | None) -> list[Image.Image]:
    """Simulate one kind and draw it at each moment."""
    thrown = scene(kind, dx)
    sim, painter = (
        Simulation(thrown, threads=threads),
        Preview(thrown, 2 * CELL[0], 2 * CELL[1], threads or 0),
    )
    drawn = []
    for moment in MOMENTS:
        sim.advance(moment - sim.time)
        image = painter.draw(np.array(sim.state.x), sim.solids(), J_P=np.array(sim.state.J_P))
        drawn.append(Image.fromarray(image).resize(CELL, Image.Resampling.LANCZOS))
    return drawn


def sheet(kinds: list[str], dx: float, threads: int | None) -> Image.Image:
    """Return all kinds on one sheet, each moment below the one before."""
    font = ImageFont.truetype(str(resources.files("neve") / "assets/FredokaOne-Regular.ttf"), 17)
    rows = -(-len(kinds) // COLUMNS)
    width, height = CELL
    page = Image.new("RGB", (COLUMNS * width, rows * len(MOMENTS) * height), (238, 242, 248))
    for index, kind in enumerate(kinds):
        for part, image in enumerate(pictures(kind, dx, threads)):
            row, column = divmod(index, COLUMNS)
            place = (column * width, (row * len(MOMENTS) + part) * height)
            page.paste(image, place)
            if part == 0:
                ImageDraw.Draw(page).text((place[0] + 10, place[1] + 6), kind, (255, 255, 255), font)
        print(kind, flush=True)
    return page


def main() -> None:
    """Read the command line and write the sheet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("docs/images/snows.jpg"))
    parser.add_argument("--kinds", nargs="*", default=list(SNOWS), choices=list(SNOWS))
    parser.add_argument("--dx", type=float, default=0.036)
    parser.add_argument("--threads", type=int)
    options = parser.parse_args()
    sheet(options.kinds, options.dx, options.threads).save(options.out, quality=78, optimize=True)


if __name__ == "__main__":
    main()
