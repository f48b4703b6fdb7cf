"""Measure how long it takes until snow lies on 200,000 triangles, and until a path-traced still shows it."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.film.render import render_run
from neve.io.atomic import write_text
from neve.render.path_tracing.picture import Choices
from neve.run.snowfall import FALL, snow_on
from neve.scene.reading.load import scene_from, to_toml
from neve.scene.schema.snowfall import Snowfall
from neve.scene.values.surfaces import square
from neve.snowfall.cover import Raster, let_fall
from neve.snowfall.surroundings import Piece, Surroundings, joined

BALLS, ROWS = 31, 40
"""Balls that hang over each other, and rows of triangles from pole to pole of each: 198,400 triangles."""
SIZE, CELLS = 10.0, 256
"""Side of the square on which it snows [m], and cells along it."""
POSTS, ROCKS = 318, 60
"""Heights along each side of the ground of the still, 200,978 triangles, and rocks on it."""


@dataclass
class Fallen:
    """Hold the time of a fall.

    Attributes:
        case: name of the case
        triangles, places, flakes, threads: sizes
        wall_s, process_s: time until the snow lies, with the tree of boxes [s]
    """

    case: str
    triangles: int
    places: int
    flakes: int
    threads: int
    wall_s: float
    process_s: float

    def text(self) -> str:
        """Return the result as a line of text."""
        return (
            f"{self.case}: {self.triangles:,} triangles, {self.places:,} places, "
            f"{self.flakes / 1e6:.1f} M flakes, "
            f"{self.threads} threads: {self.wall_s:.1f} s, {self.process_s:.1f} s of processor time"
        )


def _ball(centre: NDArray[np.float64], radius: float) -> Piece:
    t = np.linspace(0.0, np.pi, ROWS + 1)[:, None]
    p = np.linspace(0.0, 2.0 * np.pi, 2 * ROWS, endpoint=False)[None]
    x = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t) + 0.0 * p], axis=-1)
    i = np.arange((ROWS + 1) * 2 * ROWS).reshape(ROWS + 1, 2 * ROWS)
    j = np.roll(i, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (i[:-1], i[1:], j[1:], j[:-1]))
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return "ball", "closed", (centre + radius * x).reshape(-1, 3), faces.astype(np.int32)


def balls() -> Surroundings:
    """Return the ground with balls over it, whose shadows and edges are everywhere."""
    rng = np.random.default_rng(0)
    corners, faces = square()
    pieces: list[Piece] = [("ground", "ground", corners * 10.0 * SIZE, faces)]
    for _ in range(BALLS):
        x, y = rng.uniform(-0.4 * SIZE, 0.4 * SIZE, 2)
        pieces.append(_ball(np.array([x, y, rng.uniform(0.0, 2.0)]), rng.uniform(0.3, 0.8)))
    return joined(pieces)


def measure_snowfall(cells: int = CELLS) -> Fallen:
    """Let 20 cm of snow fall, with the defaults of a scene but for the flutter, and time it."""
    around = balls()
    fall = Snowfall(depth=0.2, size=(SIZE, SIZE), flutter=0.2)
    begun, spent = perf_counter(), process_time()
    cover = let_fall(fall, around, Raster.over((0.0, 0.0), (SIZE, SIZE), SIZE / cells))
    return Fallen(
        "snowfall",
        len(around.faces),
        len(cover.depth),
        cover.books.flakes,
        _core.threads(),
        perf_counter() - begun,
        process_time() - spent,
    )


@dataclass
class Still:
    """Hold the time from a scene to a path-traced picture of its snow.

    Attributes:
        case: name of the case
        triangles, places, threads: sizes
        snow_s, wall_s: until the snow lies and its frames are written, and until the picture is there [s]
        process_s: processor time of all threads until then [s]
    """

    case: str
    triangles: int
    places: int
    threads: int
    snow_s: float
    wall_s: float
    process_s: float

    def text(self) -> str:
        """Return the result as a line of text."""
        return (
            f"{self.case}: {self.triangles:,} triangles, {self.places:,} places, {self.threads} threads: "
            f"snow lies after {self.snow_s:.1f} s, its picture is there after {self.wall_s:.1f} s, "
            f"{self.process_s:.1f} s of processor time"
        )


def rocks(posts: int = POSTS) -> NDArray[np.float64]:
    """Return the heights of uneven ground with half-buried balls, (posts, posts) [m]."""
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(*(np.linspace(-0.5 * SIZE, 0.5 * SIZE, posts),) * 2, indexing="ij")
    z = 0.15 * np.sin(0.9 * x) * np.cos(0.7 * y)
    for _ in range(ROCKS):
        a, b = rng.uniform(-0.5 * SIZE, 0.5 * SIZE, 2)
        radius = rng.uniform(0.15, 0.9)
        high = np.sqrt(np.maximum(radius**2 - (x - a) ** 2 - (y - b) ** 2, 0.0))
        z = np.maximum(z, high)
    return z


def measure_still(cells: int = CELLS, posts: int = POSTS, choices: Choices | None = None) -> Still:
    """Let 20 cm of snow fall on rocks, as `neve snow --film 2`, and trace its last frame, as `neve render`.

    choices: of the picture, by default those of `neve render`.

    Errors: RenderError without Mitsuba.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "rocks.npy", rocks(posts))
        cell = SIZE / cells
        fall = {"shape": "snowfall", "depth": 0.2, "size": [SIZE, SIZE], "flutter": 0.2, "cell": cell}
        ground = {"shape": "terrain", "file": str(folder / "rocks.npy"), "size": [SIZE, SIZE]}
        view = {"position": [6.5, -8.0, 4.0], "target": [0.0, -0.5, 0.2], "fov": 40.0}
        keys = {"numerics": {"dx": 2.0 * cell}, "sources": [fall], "colliders": [ground], "camera": view}
        scene = folder / "rocks.toml"
        write_text(scene, to_toml(scene_from(keys)))
        begun, spent = perf_counter(), process_time()
        cover, made = snow_on(str(scene), str(folder / "snow"), film=2)
        lain = perf_counter() - begun
        render_run(made / FALL, choices or Choices(), frames=slice(1, 2))
        return Still(
            "snowed_still",
            2 * (posts - 1) ** 2,
            len(cover.depth),
            _core.threads(),
            lain,
            perf_counter() - begun,
            process_time() - spent,
        )
