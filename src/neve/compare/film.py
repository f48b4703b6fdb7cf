"""The film of a comparison: the pictures of each method's run side by side, at the same times."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neve.build import solids
from neve.io.atomic import write_png
from neve.io.frames import frame_numbers, read_frame
from neve.io.run_folder import RunFolder
from neve.render.caption import captioned
from neve.render.film import Film
from neve.run.painter import Painter
from neve.scene.schema.scene import Scene

FILM, STILL = "compare.mp4", "compare.png"
PANEL = (800, 450)
"""Width and height of one method's picture [pixels]."""
ACROSS = 2
"""Pictures beside each other; more methods come below."""


def draw_film(path: Path, runs: Mapping[str, tuple[Scene, Path]], threads: int | None = None) -> None:
    """Draw the film `path` of `runs`: scene and run folder of each method, in the order of the panels.

    Beside it lies STILL, the picture in which they differ most. Errors: RunError, FilmError.
    """
    painters = {m: Painter(scene, solids(scene), threads, PANEL) for m, (scene, _) in runs.items()}
    folders = {method: RunFolder(folder).frames for method, (_, folder) in runs.items()}
    numbers = sorted(set.intersection(*(set(frame_numbers(folder)) for folder in folders.values())))
    rows = -(-len(runs) // ACROSS)
    size = (min(len(runs), ACROSS) * PANEL[0], rows * PANEL[1])
    fps = next(iter(runs.values()))[0].run.fps
    most, still = -1.0, None
    film = Film(path, fps, size)
    for index, number in enumerate(numbers):
        panels = {m: painters[m].draw(read_frame(folders[m], number)) for m in runs}
        picture = _joined([captioned(panel, method, top=True) for method, panel in panels.items()])
        film.add(picture, index=index)
        if (difference := _difference(list(panels.values()))) >= most:
            most, still = difference, picture
    film.close()
    if still is not None:
        write_png(path.with_name(STILL), still)


def _joined(panels: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Return the panels (h, w, 3) in rows of ACROSS; what is left over is black."""
    if len(panels) <= ACROSS:
        return np.concatenate(panels, axis=1)
    panels = panels + [np.zeros_like(panels[0])] * (-len(panels) % ACROSS)
    rows = [np.concatenate(panels[i : i + ACROSS], axis=1) for i in range(0, len(panels), ACROSS)]
    return np.concatenate(rows, axis=0)


def _difference(panels: list[NDArray[np.uint8]]) -> float:
    """Return how much the panels differ from the first, in the mean over pixels."""
    first = panels[0].astype(np.int16)
    return float(sum(np.mean(np.abs(panel.astype(np.int16) - first)) for panel in panels[1:]))
