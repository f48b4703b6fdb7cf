"""Run a sweep: its folder, its runs on a cluster, its table."""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from neve.io.assets import assets_of, portable
from neve.io.atomic import write_text, writing
from neve.io.errors import RunError, cannot_read
from neve.io.run_folder import RunFolder
from neve.run.resume import check_same
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, to_toml
from neve.scene.schema.scene import Scene
from neve.sweep import table
from neve.sweep.before import begun, known_rows
from neve.sweep.design import Point, changes_of
from neve.sweep.inputs import distinct, inputs_of, name_of
from neve.sweep.measures import Measure, Own, check, kinds, usual
from neve.sweep.table import DONE, FAILED, Row
from neve.sweep.task import Task, carry_out
from neve.system import disk
from neve.system.cluster import cluster, is_killed, require_dask, results
from neve.system.processors import cores

CARD = "sweep.json"
"""Which run has which values, and of what scene."""
FORMAT = 1
Progress = Callable[[int, int, int], None]
"""Called after each run: how many are done, of how many, and how many were run just now."""


@dataclass(frozen=True)
class Sweep:
    """Hold what a sweep is: a scene, changes that all runs have, and the values of each.

    scene: the name of a preset or the path of a scene file. frames: number of the last frame of each run
    measures: columns of the table; without any, all numbers of the log at the last frame
    """

    scene: str
    points: Sequence[Point]
    changes: Sequence[str] = ()
    measures: Sequence[Measure] = ()
    functions: Sequence[Own] = ()
    frames: int | None = None


def sweep(
    plan: Sweep,
    out: Path | str,
    workers: int | None = None,
    threads: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    progress: Progress = lambda done, of, new: None,
) -> list[Row]:
    """Run what is missing of `plan`, each run a folder in `out`; write the table there, and return its rows.

    A folder that holds this scene's sweep is gone on with, also with more values: runs that are there stay.
    Runs have the bits that they would have alone. A run that fails has its sentence in the table.

    workers: processes, by default one for each processor that this one may use. threads: of each run, by
    default these shared out, or those of the worker that does it. scheduler: address of a Dask cluster, whose
    workers see the folder `out` under the same path.
    force: begin all runs anew

    Errors: SceneError if no run has a scene that can be used; RunError; ClusterError.
    """
    require_dask()
    folder = Path(out).resolve()
    plan = dataclasses.replace(plan, points=distinct(plan.points))
    scenes = [_scene(plan, point) for point in plan.points]
    good = {k: found for k, found in enumerate(scenes) if isinstance(found, Scene)}
    if not good and isinstance(scenes[0], SceneError):
        raise scenes[0]
    inputs = inputs_of(plan.points, scenes)
    checked = _measures(plan, kinds(good.values()), [*inputs[0]])
    with RunFolder(folder).lock():
        names = _open(folder, plan)
        processors = cores()
        workers = min(workers or processors, len(scenes))
        share = threads or (None if scheduler else max(1, processors // workers))
        more = (checked, tuple(plan.functions), share, plan.frames, force)
        tasks = {k: Task(folder / names[k], inputs[k], to_toml(scene), *more) for k, scene in good.items()}
        if not force:
            _require_same((tasks[k].folder, scene) for k, scene in good.items())
        before = {} if force else known_rows(folder)
        rows = [
            begun(tasks[k], before.get(name), scene) if isinstance(scene, Scene)
            else Row(name, inputs[k], FAILED, str(scene))
            for k, (name, scene) in enumerate(zip(names, scenes, strict=True))
        ]  # fmt: skip
        table.write(folder, rows)
        _carry_out(folder, rows, tasks, workers, scheduler, progress)
    return rows


def _carry_out(
    folder: Path,
    rows: list[Row],
    tasks: dict[int, Task],
    workers: int,
    scheduler: str | None,
    progress: Progress,
) -> None:
    """Do the tasks and put their rows in place, and the table on the disk after each."""
    numbers = [*tasks]
    done = len(rows) - len(tasks)
    try:
        with cluster(workers, scheduler) as client:
            for new, (k, found) in enumerate(results(client, carry_out, [*tasks.values()]), 1):
                number = numbers[k]
                rows[number] = found if isinstance(found, Row) else _lost(tasks[number], found)
                table.write(folder, rows)
                progress(done + new, len(rows), new)
    except KeyboardInterrupt:
        there = sum(row.status == DONE for row in rows)
        raise KeyboardInterrupt(
            f"stopped after {there} of {len(rows)} runs; the same command goes on with the rest"
        ) from None


def _lost(task: Task, error: BaseException) -> Row:
    """Return the row of a run that came to no end of its own."""
    if is_killed(error):
        return task.failed("each process that ran it was ended from outside, maybe for lack of memory.")
    return task.failed(f"{type(error).__name__}: {error}")


def _scene(plan: Sweep, point: Point) -> Scene | SceneError:
    try:
        return load(plan.scene, [*plan.changes, *changes_of(point)])
    except SceneError as error:
        return error


def _measures(plan: Sweep, kinds: Sequence[Scene], inputs: Sequence[str]) -> tuple[Measure, ...]:
    """Return the columns of the table. Errors: RunError for one that no run has, or that is there twice."""
    measures = tuple(plan.measures) or tuple(usual(kinds) if not plan.functions else ())
    check(measures, kinds)
    taken = [*table.OWN, *inputs, *(measure.name for measure in measures)]
    if twice := sorted({name for name in taken if taken.count(name) > 1}):
        raise RunError(f"output {twice[0]}: the table has another column of this name; choose another.")
    return measures


def _open(folder: Path, plan: Sweep) -> list[str]:
    """Make the folder ready; return the name of each run: the one it has, or the next number that is free.

    Errors: RunError if the folder holds anything else.
    """
    card = folder / CARD
    if card.exists():
        known = _known(card)
    elif any(not disk.is_temporary(path.name) for path in folder.iterdir()):
        raise RunError(f"{folder} is not empty and holds no sweep: choose another --out.")
    else:
        known = {}
    with writing(folder):
        disk.sweep(folder)
    taken = {*known.values()}
    free = (name for n in itertools.count(1) if (name := f"{n:04d}") not in taken)
    wanted = [_values(plan, point, known) for point in plan.points]
    for values in wanted:
        if values not in known:
            known[values] = next(free)
    write_text(card, json.dumps({"format": FORMAT, "runs": known}, indent=1))
    return [known[values] for values in wanted]


def _values(plan: Sweep, point: Point, known: Mapping[str, str]) -> str:
    """Return the values of a run as one text: as the folder has them, or put in order."""
    changes = [*plan.changes, *changes_of(point)]
    plain = " ".join(changes)
    return plain if plain in known else name_of(changes)


def _known(card: Path) -> dict[str, str]:
    """Return the names of the runs by their values. Errors: RunError."""
    try:
        held = json.loads(disk.read_bytes(card))
        known = held["runs"] if held["format"] == FORMAT else None
    except OSError as error:
        raise cannot_read(card, error) from error
    except (ValueError, KeyError, TypeError):
        known = None
    if not isinstance(known, dict) or not all(
        isinstance(name, str) and name.isdigit() for name in known.values()
    ):
        raise RunError(f"{card} is damaged or of another version of Neve: choose another --out.")
    return known


def _require_same(runs: Iterable[tuple[Path, Scene]]) -> None:
    """Refuse to go on with runs of another scene; runs: folders and scenes. Errors: RunError."""
    for folder, scene in runs:
        run = RunFolder(folder)
        if run.has_begun() and run.scene.is_file():
            before = disk.read_bytes(run.scene).decode(errors="replace")
            check_same(run.scene, before, portable(scene, assets_of(scene)))
