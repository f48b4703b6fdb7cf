"""Export the frames of a run folder."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from neve.build import solids as solids_of
from neve.export.axes import Axes, Up
from neve.export.camera import FilmCamera
from neve.export.folder import ExportFolder
from neve.export.format import Format, Job
from neve.export.moment import check_names, columns_of, moment_of
from neve.export.registry import FORMATS
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError, cannot_read
from neve.io.frames import FOR_LIFE, Frame, Life, chosen_frames, frame_numbers, frame_path, read_frame
from neve.io.npz import mark_of
from neve.io.run_folder import RunFolder
from neve.system.cluster import elsewhere

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.scene.schema.scene import Scene

Progress = Callable[[int, int, int], None]
"""Called after a frame is written: how many are there, how many are asked for, and its particles."""


@dataclass(frozen=True)
class Choices:
    """Hold what a user chooses of an export.

    fields: of particles, None for those that the run has; up: axis, None for what is usual for the format;
    scale: units of the file in a metre
    """

    to: str
    fields: tuple[str, ...] | None = None
    up: Up | None = None
    scale: float = 1.0

    @property
    def format(self) -> type[Format]:
        """The class of the format. Errors: ValueError."""
        found: type[Format] = FORMATS.get(self.to)
        return found

    @property
    def axes(self) -> Axes:
        """Axes and unit of the files."""
        return Axes(self.up or self.format.up, self.scale)

    def job(self, folder: Path, scene: Scene, solids: Sequence[Solid], radius: float | None = None) -> Job:
        """Return what is the same in all moments; radius: of a particle [m], None for the scene's."""
        spacing = scene.numerics.spacing if radius is None else 2.0 * radius
        return Job(
            folder,
            tuple(solids),
            self.axes,
            scene.run.fps,
            spacing * self.scale,
            scene.numerics.dx * self.scale,
            scene.about,
            FilmCamera(scene.camera, solids, scene.numerics.dx, self.axes),
        )

    def names(self, first: Frame, life: Sequence[str]) -> tuple[str, ...]:
        """Return the fields to write, given a frame and what particles keep for life. Errors: RunError."""
        columns = columns_of(first)
        matrices = [name for name, values in columns.items() if values.ndim == 3 or values.shape[1:] == (6,)]
        if self.fields is None:
            left_out = () if self.format.takes_matrices else matrices
            return tuple(name for name in columns if name not in left_out) if self.format.takes_fields else ()
        if not self.format.takes_fields:
            raise RunError(f"--fields: the format {self.to} has no fields of particles; leave it out.")
        check_names(self.fields, (*columns, *life), "--fields")
        if not self.format.takes_matrices and (wrong := [name for name in self.fields if name in matrices]):
            raise RunError(f"--fields: {wrong[0]} is a matrix, which the format {self.to} has no place for.")
        return self.fields

    def options(self, names: Sequence[str]) -> dict[str, Any]:
        """Return what two exports must have in common for one to go on with the other."""
        return {"to": self.to, "fields": list(names), "up": self.axes.up, "scale": self.scale}


def export_run(
    path: Path | str,
    choices: Choices,
    out: Path | str | None = None,
    frames: slice | None = None,
    force: bool = False,
    progress: Progress = lambda done, of, particles: None,
    scheduler: str | None = None,
) -> tuple[Path, int]:
    """Export frames of the run folder `path`; return the folder of the files and how many frames are new.

    out: the folder, by default one in the run folder, named as the format
    frames: numbers from start to stop, without stop, by step; None for all
    force: begin anew; else what is there, from the same frames and with the same choices, is kept
    scheduler: address of a Dask cluster that writes instead, where a frame has files of its own; its workers
    see the run and `out` under the same paths

    Memory follows the largest frame, not their number.

    Errors: RunError, SceneError, ValueError: no run, no such frame, field or format, the disk refuses.
    """
    from neve.scene.reading.load import load

    run, target = _places(path, out, choices, scheduler)
    wanted = chosen_frames(run.frames, frames, "export")
    scene = load(run.path)
    life = _life(run, choices)
    names = choices.names(read_frame(run.frames, wanted[0]), () if life is None else tuple(life.columns))
    if choices.format.weighs and (life is None or "m" not in life.columns):
        raise RunError(f"the particles of {run.path} have no mass, which the format {choices.to} needs.")
    job = choices.job(target, scene, solids_of(scene))
    format = choices.format(job)
    folder = ExportFolder(target)
    folder.check(choices.options(names), force)
    with RunFolder(target).lock():
        folder.open(choices.options(names), force)
        _drop_others(run, format, folder)
        missing = _missing(run, wanted, format, folder)
        try:
            folder.announce(format.shared_names())
            with format:
                _show(run, job)
                if missing:
                    format.begin([number for number, _ in missing])
                marks = dict(missing)
                written = _written(run, [*marks], format, folder, choices, names, life, scheduler)
                for done, (number, time, particles) in enumerate(written, 1 + len(wanted) - len(missing)):
                    folder.add(number, time, marks[number])
                    progress(done, len(wanted), particles)
                format.close(folder.times())
        except BaseException:
            if format.whole and missing:
                folder.forget()
            raise
        finally:
            folder.save()
    return target, len(missing)


def _places(
    path: Path | str, out: Path | str | None, choices: Choices, scheduler: str | None
) -> tuple[RunFolder, Path]:
    """Return the run and the folder of the files, as all processes see them. Errors: RunError."""
    if scheduler is not None and choices.format.whole:
        raise RunError(f"--scheduler: the format {choices.to} has one file of all frames; leave it out.")
    run = RunFolder(path if scheduler is None else Path(path).absolute())
    if not run.is_run():
        raise RunError(f"{path} holds no Neve run, so there is nothing to export.")
    target = Path(out) if out is not None else run.path / choices.to
    return run, target if scheduler is None else target.absolute()


def _show(run: RunFolder, job: Job) -> None:
    """Show all frames of the run to a camera that follows something."""
    for number in frame_numbers(run.frames) if job.camera.follows else ():
        with contextlib.suppress(RunError):  # of a damaged frame; one that is asked for is refused later
            job.camera.see(read_frame(run.frames, number))


Written = tuple[int, float, int]
"""Of a frame that is exported: its number, its time [s] and its number of particles."""


def _written(
    run: RunFolder,
    numbers: Sequence[int],
    format: Format,
    folder: ExportFolder,
    choices: Choices,
    names: Sequence[str],
    life: Life | None,
    scheduler: str | None,
) -> Iterator[Written]:
    """Export frames, here or on a cluster; yield them as they are done."""
    if scheduler is not None:
        folder.announce([name for number in numbers for name in format.names(number)])
        folder.save()
        yield from elsewhere(scheduler, _frame_elsewhere, numbers, run, choices, format.job.folder)
        return
    for number in numbers:
        folder.announce(format.names(number))
        yield _frame(run, number, format, names, life)


def _frame(run: RunFolder, number: int, format: Format, names: Sequence[str], life: Life | None) -> Written:
    """Export one frame; nothing of it stays in memory."""
    content = read_frame(run.frames, number)
    moment = moment_of(number, content, format.job.axes, names, life, format.weighs)
    format.write(moment)
    return number, moment.time, len(moment.x)


def _frame_elsewhere(number: int, run: RunFolder, choices: Choices, target: Path) -> Written:
    """Export one frame in a process that has seen nothing of the run."""
    from neve.scene.reading.load import load

    scene, life = load(run.path), _life(run, choices)
    names = choices.names(read_frame(run.frames, number), () if life is None else tuple(life.columns))
    job = choices.job(target, scene, solids_of(scene))
    with choices.format(job) as format:
        _show(run, job)
        format.begin([number])
        return _frame(run, number, format, names, life)


def _drop_others(run: RunFolder, format: Format, folder: ExportFolder) -> None:
    """Remove the frames that come from frame files which the run does not have now: those of an older run."""
    present = {number: _mark(run, number) for number in {*folder.times()} & {*frame_numbers(run.frames)}}
    folder.keep(present, (lambda frame: ()) if format.whole else format.names)


def _mark(run: RunFolder, number: int) -> int:
    """Return the mark of a frame file, 0 for a damaged one. Errors: RunError if it cannot be read."""
    source = frame_path(run.frames, number)
    try:
        return mark_of(source) or 0
    except OSError as error:
        raise cannot_read(source, error) from error


def _missing(
    run: RunFolder, wanted: Sequence[int], format: Format, folder: ExportFolder
) -> list[tuple[int, int]]:
    """Return the frames that the export lacks, or has from another frame file, with marks of the files.

    Files that belong to all frames are written with any frame: if one is lost, the first frame is missing.
    """
    found = [(number, _mark(run, number)) for number in wanted]
    missing = [(number, mark) for number, mark in found if not folder.has(number, mark, format.names(number))]
    if not format.whole:
        return missing if missing or folder.lies(format.shared_names()) else found[:1]
    if not missing and list(folder.times()) == list(wanted):
        return []
    folder.forget()
    return found


def _life(run: RunFolder, choices: Choices) -> Life | None:
    """Return what the checkpoint knows of the particles, if it is needed or asked for."""
    if not choices.format.weighs and not {*FOR_LIFE} & {*(choices.fields or ())}:
        return None
    arrays = read_checkpoint(run.checkpoint).arrays
    return Life(arrays["id"], {name: arrays[name] for name in FOR_LIFE if name in arrays})
