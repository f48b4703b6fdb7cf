"""Run one scene by each method, and write film, table and page of the comparison."""

from __future__ import annotations

import csv
import dataclasses
import io
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from neve.compare.film import FILM, draw_film
from neve.compare.measures import UNITS, Curve, Measures, measured
from neve.compare.page import PAGE, page
from neve.io.atomic import write_text
from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.registry import METHODS
from neve.run import run_scene
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.scene import Scene

TABLE = "compare.csv"
"""A row for each method, columns as the members of `Measures`."""


@dataclass(frozen=True)
class Compared:
    """Hold one method's part: its measures and curve; or, in `refused`, why it does not take the scene."""

    method: str
    measures: Measures | None = None
    curve: Curve | None = None
    refused: str = ""


def chosen_methods(text: str | None) -> list[str]:
    """Return the methods in `text`, separated by commas; all that there are without it. Errors: RunError."""
    names = list(METHODS.names()) if text is None else [name.strip() for name in text.split(",")]
    for name in names:
        try:
            METHODS.checked(name)
        except ValueError as error:
            raise RunError(f"--methods: {error}") from None
    if len(set(names)) != len(names):
        raise RunError("--methods names a method twice.")
    return names


def compare(
    load: Callable[[str], Scene],
    methods: Sequence[str],
    folder: Path,
    frames: int | None = None,
    threads: int | None = None,
    force: bool = False,
    quiet: bool = False,
) -> list[Compared]:
    """Run what `load` returns for each of `methods`, each into a run folder of its name in `folder`.

    Writes FILM, TABLE and PAGE beside them. frames: number of the last frame. A method that refuses the scene
    has its sentence in the page.

    Errors: SceneError if all methods refuse it; RunError for a folder that cannot be used.
    """
    scenes = {method: load(method) for method in methods}
    found = [
        _run(scenes[method], method, folder / method, frames, threads, force, quiet) for method in methods
    ]
    if all(part.refused for part in found):
        raise SceneError(found[0].refused)
    ran = [part.method for part in found if not part.refused]
    draw_film(folder / FILM, {method: (scenes[method], folder / method) for method in ran}, threads)
    write_text(folder / TABLE, table(found))
    write_text(folder / PAGE, page(scenes[ran[0]], found))
    return found


def _run(
    scene: Scene, method: str, folder: Path, frames: int | None, threads: int | None, force: bool, quiet: bool
) -> Compared:
    """Run the scene by one method."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            sim = run_scene(scene, folder, threads=threads, frames=frames, force=force, quiet=quiet)
    except SceneError as error:
        return Compared(method, refused=str(error))
    return Compared(method, *measured(sim, RunFolder(folder).log))


def table(found: Sequence[Compared]) -> str:
    """Return the table as text, a row for each method that ran."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["method", *(f"{name} [{unit}]" if unit else name for name, unit in UNITS.items())])
    for part in found:
        if part.measures:
            writer.writerow([part.method, *dataclasses.astuple(part.measures)])
    return out.getvalue()
