"""The run loop: frame by frame into a run folder.

The loop never changes: it advances the simulation by one frame and hands the frame to each output whose
schedule says so. Which outputs there are is up to the scene, the registry (`neve.run.outputs.registry`) and
the caller.
"""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from neve.io.assets import assets_of, keep_assets, portable
from neve.io.atomic import write_text
from neve.io.checkpoint import Checkpoint, read_checkpoint
from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.io.version import build, version
from neve.run.interrupt import Interrupt
from neve.run.large import in_words
from neve.run.outputs.context import Begins, FrameContext, Output, Resumes, RunContext
from neve.run.outputs.registry import BUILT_IN, entries, kinds, own_schedule, schedule_of, usual_files
from neve.run.progress import Progress, Warnings, follow, warnings_to
from neve.run.resume import check_same, is_drawn_alike
from neve.scene.errors import SceneError
from neve.scene.schema.outputs import RESERVED
from neve.spelling import hint, nearest
from neve.stage_timer import StageTimer
from neve.system.arguments import whole

if TYPE_CHECKING:
    from neve.scene.schema.outputs import OutputOptions
    from neve.scene.schema.scene import Scene
    from neve.schedule import Schedule
    from neve.simulation import Simulation


OUTPUTS = "neve.run.outputs."
"""Modules of the outputs that come with Neve."""


def run(
    sim: Simulation,
    out: Path | str,
    frames: int | None = None,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
    outputs: Sequence[Output] = (),
) -> Simulation:
    """Run `sim` into the folder `out` and return the simulation at the last frame.

    out: folder of the run; it must be new or empty, or hold a run and come with `resume` or `force`
    frames: number of the last frame; by default `run.duration` times `run.fps` of the scene
    resume: continue from the run's checkpoint; of `sim` only its scene and threads count then
    force: replace the run that lies in `out`
    quiet: show no progress, only warnings
    outputs: further outputs, besides those of the scene; see `neve.run.outputs.context.Output`

    Frame 0 is the state at the start. The same scene gives the same frames, bit for bit, whether the run was
    stopped and resumed or not.

    Errors: RunError for a folder or disk that refuses; what `sim.advance` raises; KeyboardInterrupt after
    Ctrl-C, which first finishes the frame and writes the checkpoint (a second Ctrl-C stops at once).
    """

    def start(checkpoint: Checkpoint | None) -> Simulation:
        if checkpoint is None:
            return sim
        return type(sim).restore(sim.scene, checkpoint.arrays, threads=sim.threads)

    return _run(sim.scene, start, RunFolder(out), frames, resume, force, quiet, outputs)


def run_scene(
    scene: Scene,
    out: Path | str,
    threads: int | None = None,
    frames: int | None = None,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
    over_ranks: bool = False,
) -> Simulation:
    """Run `scene` into `out` like `run`, and fill it with snow only once the folder is known to be right.

    over_ranks: run over all ranks of this launch (`neve.ranks`), which follow this one
    """
    RunFolder(out).check(resume, force)
    kind = _kind_of_simulation(out, over_ranks)

    def start(checkpoint: Checkpoint | None) -> Simulation:
        if checkpoint is None:
            return kind(scene, threads=threads)
        return kind.restore(scene, checkpoint.arrays, threads=threads)

    return _run(scene, start, RunFolder(out), frames, resume, force, quiet, ())


def _kind_of_simulation(out: Path | str, over_ranks: bool) -> type[Simulation]:
    """Return the class of the simulation that this process runs into `out`: on one rank, or over several."""
    if over_ranks:
        from neve.ranks.simulation import RankSimulation
        from neve.ranks.world import resumable

        resumable(out)

        return RankSimulation
    from neve.simulation import Simulation

    return Simulation


def last_frame(scene: Scene, frames: int | None) -> int:
    """Return the number of the last frame: `frames`, or what the scene's duration holds, at least one."""
    if frames is None:
        return max(1, round(scene.run.duration * scene.run.fps))
    frames = whole(frames, "argument frames", "the number of the last frame")
    if frames < 1:
        raise ValueError(f"argument frames = {frames} is not the number of a last frame, 1 or more")
    return frames


def _run(
    scene: Scene,
    start: Callable[[Checkpoint | None], Simulation],
    folder: RunFolder,
    frames: int | None,
    resume: bool,
    force: bool,
    quiet: bool,
    outputs: Sequence[Output],
) -> Simulation:
    """Make the folder ready, start or restore the simulation, and run the loop with the run's outputs."""
    folder.check(resume, force)
    assets = assets_of(scene)
    toml = portable(scene, assets)
    asked = entries(scene)
    with folder.lock():
        if large := in_words(scene):
            follow(folder.path.name, 0, 1, quiet).say(f"{folder.path.name}: making ready {large}")
        checkpoint = read_checkpoint(folder.checkpoint) if resume and folder.has_begun() else None
        if checkpoint is not None:
            check_same(folder.checkpoint, checkpoint.scene, toml)
        sim = _started(start, checkpoint, folder.checkpoint)
        _check_fields(sim)
        done = None if checkpoint is None else checkpoint.frame
        made = _made(scene, asked, outputs)  # before the folder loses the run that is replaced
        folder.open(version(), resume, force, {*usual_files(), *(given.file() for given in asked)} - {""})
        keep_assets(folder.path, assets)
        write_text(folder.scene, toml)
        if done is not None:
            folder.drop_frames_after(done)
        last = max(last_frame(scene, frames), done or 0)
        context = RunContext(
            folder=folder,
            scene=scene,
            toml=toml,
            neve=build(),
            solids=[solid for solid, _ in sim.solids()],
            done=done,
            redraw=checkpoint is not None and not is_drawn_alike(checkpoint.scene, toml),
            threads=sim.threads,
            radius=sim.radius,
            reserved={*RESERVED, *usual_files(BUILT_IN)},
            inventory=None if checkpoint is None else checkpoint.inventory,
        )
        with contextlib.ExitStack() as stack:
            progress = stack.enter_context(follow(folder.path.name, done or 0, last, quiet))
            stack.enter_context(warnings_to(Warnings() if quiet else progress))
            scheduled = _begin(context, made, stack)
            if scene.caption:
                progress.say(f"{folder.path.name}: {scene.caption}")
            if checkpoint is not None:
                _warn_of_version(folder.path, checkpoint.neve)
            interrupt = stack.enter_context(Interrupt(quiet))
            reached = _loop(sim, context, last, scheduled, progress, interrupt)
            if reached < last:
                raise KeyboardInterrupt(
                    f"stopped after frame {reached} of {last}; continue with: neve run {folder.path} --resume"
                )
            progress.say(f"{folder.path}: frames 0 to {last} are done")
    return sim


def _started(
    start: Callable[[Checkpoint | None], Simulation], checkpoint: Checkpoint | None, path: Path
) -> Simulation:
    """Start or restore the simulation. Errors: RunError for a checkpoint that is not of this scene."""
    if checkpoint is None:
        return start(None)
    try:
        sim = start(checkpoint)
        if not abs(sim.time * sim.scene.run.fps - checkpoint.frame) < 0.5:
            raise ValueError(f"frame {checkpoint.frame} at {sim.time} s")
    except SceneError:
        raise
    except (ValueError, TypeError, IndexError, ArithmeticError) as error:
        why = " ".join(str(error).split())
        raise RunError(
            f"{path} does not fit its scene ({why}), so it is damaged or of another run:"
            " start over with --force."
        ) from error
    return sim


def _check_fields(sim: Simulation) -> None:
    """Refuse a name in `run.fields` that is no field of the particles. Errors: RunError."""
    if not sim.scene.run.fields:
        return
    known = sorted(sim.columns())
    for i, name in enumerate(sim.scene.run.fields):
        if name not in known:
            meant = hint(nearest(name, known), "use " + ", ".join(known))
            raise RunError(f'run.fields.{i} = "{name}" is no field of the particles{meant}.')


def _made(
    scene: Scene, asked: Sequence[OutputOptions], more: Sequence[Output]
) -> list[tuple[Schedule, Output]]:
    """Make the outputs that are asked for and return all in the order of writing. Errors: RunError."""
    fps = scene.run.fps
    made = [(kinds()[given.kind], given) for given in asked]
    outputs = [(kind.completes, given, kind.make(**given.options())) for kind, given in made]
    rows = [(last, schedule_of(given, output, fps), output) for last, given, output in outputs]
    rows += [(False, own_schedule(output), output) for output in more]
    scheduled = [(schedule, output) for _, schedule, output in sorted(rows, key=lambda row: row[0])]
    names = [output.name for _, output in scheduled if hasattr(output, "name")]
    if twice := [name for name in names if names.count(name) > 1]:
        raise RunError(f"two outputs of the run write {twice[0]}: give one of them another name.")
    return scheduled


def _begin(
    run: RunContext, scheduled: list[tuple[Schedule, Output]], stack: contextlib.ExitStack
) -> list[tuple[Schedule, Output]]:
    """Let all outputs begin, and then what is done beside the steps, which ends before them."""
    for schedule, output in scheduled:
        if isinstance(output, Begins):
            output.begin(run, schedule)
        if isinstance(output, contextlib.AbstractContextManager):
            stack.enter_context(output)
    stack.enter_context(run.beside)
    return scheduled


def _warn_of_version(folder: Path, before: str) -> None:
    if before != build():
        logging.getLogger("neve").warning(
            "%s: the run was started with Neve %s and continues with %s, so its bits may differ from those of"
            " a run in one go",
            folder,
            before,
            build(),
        )


def _loop(
    sim: Simulation,
    run: RunContext,
    last: int,
    outputs: Sequence[tuple[Schedule, Output]],
    progress: Progress,
    interrupt: Interrupt,
) -> int:
    """Advance frame by frame, stop between frames when the user asks, and return the last frame done.

    A checkpoint means that its frame is complete, so it is written last in a frame and closed first of all.
    """
    timer = StageTimer()
    frame = run.done or 0
    context = FrameContext(sim, frame, last, timer, run)
    if run.done is None:
        _write(context, outputs)
        run.beside.wait()
        run.folder.begin()
    else:
        for _, output in outputs:
            if isinstance(output, Resumes):
                output.resume(context)
    progress.update(frame, sim.count, sim.steps)
    while frame < last and not interrupt.requested:
        sim.advance(1.0 / sim.scene.run.fps)
        frame += 1
        context = FrameContext(sim, frame, last, timer, run)
        _write(context, outputs)
        progress.update(frame, sim.count, sim.steps)
    run.beside.wait()
    for _, output in reversed(outputs):
        output.close(context)
        run.beside.wait()
    return frame


def _write(context: FrameContext, outputs: Sequence[tuple[Schedule, Output]]) -> None:
    """Write a frame; an output of a user finds all that is written before it."""
    for schedule, output in outputs:
        if schedule.due(context.frame):
            if not type(output).__module__.startswith(OUTPUTS):
                context.run.beside.wait()
            output.write(context)
