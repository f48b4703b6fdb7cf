"""The run loop: frame by frame into a run folder.

The loop never changes: it advances the simulation by one frame and hands the frame to each output whose
schedule says so. Frames, log, checkpoint and film are outputs; more can be given as `observers`.
"""

from __future__ import annotations

import contextlib
import logging
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from neve.io.assets import assets_of, keep_assets, portable, same_content
from neve.io.atomic import write_text
from neve.io.checkpoint import Checkpoint, read_checkpoint
from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.io.version import version
from neve.run.bodies import BodyOutput
from neve.run.fragments import FragmentOutput
from neve.run.interrupt import Interrupt
from neve.run.outputs import CheckpointOutput, FrameContext, FrameOutput, LogOutput, Output
from neve.run.pictures import FilmOutput, Painter, PictureOutput
from neve.run.progress import Progress, Warnings, follow, warnings_to
from neve.stage_timer import StageTimer

if TYPE_CHECKING:
    from neve.scene.schema.scene import Scene
    from neve.simulation import Simulation

# What may differ between the scene of a run and the scene it is gone on with: nothing that moves snow.
_FREE = ("about", "camera", "light", "run.duration", "run.film", "run.fragments")


def run(
    sim: Simulation,
    out: Path | str,
    frames: int | None = None,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
    observers: Sequence[Output] = (),
) -> Simulation:
    """Run `sim` into the folder `out` and return the simulation at the last frame.

    out: folder of the run; it must be new or empty, or hold a run and come with `resume` or `force`
    frames: number of the last frame; by default `run.duration` times `run.fps` of the scene
    resume: go on from the run's checkpoint; of `sim` only its scene and threads count then
    force: replace the run that lies in `out`
    quiet: show no progress, only warnings
    observers: further outputs

    Frame 0 is the state at the start. The same scene gives the same frames, bit for bit, whether the run was
    stopped and resumed or not.

    Errors: RunError for a folder or disk that refuses; what `sim.advance` raises; KeyboardInterrupt after
    Ctrl-C, which first finishes the frame and writes the checkpoint (a second Ctrl-C stops at once).
    """

    def start(checkpoint: Checkpoint | None) -> Simulation:
        if checkpoint is None:
            return sim
        return type(sim).restore(sim.scene, checkpoint.arrays, threads=sim.threads)

    return _run(sim.scene, start, RunFolder(out), frames, resume, force, quiet, observers)


def run_scene(
    scene: Scene,
    out: Path | str,
    threads: int | None = None,
    frames: int | None = None,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
) -> Simulation:
    """Run `scene` into `out` like `run`, and fill it with snow only once the folder is known to be right."""
    RunFolder(out).check(resume, force)
    from neve.simulation import Simulation

    def start(checkpoint: Checkpoint | None) -> Simulation:
        if checkpoint is None:
            return Simulation(scene, threads=threads)
        return Simulation.restore(scene, checkpoint.arrays, threads=threads)

    return _run(scene, start, RunFolder(out), frames, resume, force, quiet, ())


def last_frame(scene: Scene, frames: int | None) -> int:
    """Return the number of the last frame: `frames`, or what the scene's duration holds, at least one."""
    return frames if frames is not None else max(1, round(scene.run.duration * scene.run.fps))


def _run(
    scene: Scene,
    start: Callable[[Checkpoint | None], Simulation],
    folder: RunFolder,
    frames: int | None,
    resume: bool,
    force: bool,
    quiet: bool,
    observers: Sequence[Output],
) -> Simulation:
    """Make the folder ready, start or restore the simulation, and run the loop with the run's outputs."""
    folder.check(resume, force)
    assets = assets_of(scene)
    toml = portable(scene, assets)
    with folder.lock():
        checkpoint = read_checkpoint(folder.checkpoint) if resume else None
        if checkpoint is not None:
            _check_same(folder.path, checkpoint.scene, toml)
        sim = start(checkpoint)
        done = None if checkpoint is None else checkpoint.frame
        folder.open(version(), resume, force)
        keep_assets(folder.path, assets)
        write_text(folder.scene, toml)
        if done is not None:
            folder.drop_frames_after(done)
        last = max(last_frame(scene, frames), done or 0)
        with contextlib.ExitStack() as stack:
            painter = Painter(scene, [solid for solid, _ in sim.bodies()], sim.threads)
            outputs: list[Output] = [FrameOutput(folder), PictureOutput(folder, painter)]
            if scene.run.film:
                anew = checkpoint is not None and _looks(checkpoint.scene) != _looks(toml)
                outputs.append(stack.enter_context(FilmOutput(folder, scene, painter, done, anew)))
            if scene.run.fragments:
                outputs.append(FragmentOutput(folder, scene, done))
            if sim.bodies():
                outputs.append(BodyOutput(folder, done))
            outputs += [LogOutput(folder, done), *observers]
            outputs.append(CheckpointOutput(folder, toml, version(), done))
            progress = stack.enter_context(follow(folder.path.name, done or 0, last, quiet))
            stack.enter_context(warnings_to(Warnings() if quiet else progress))
            if checkpoint is not None and checkpoint.neve != version():
                logging.getLogger("neve").warning(
                    "%s: the run was begun with Neve %s and goes on with %s, so its bits may differ from"
                    " those of a run in one go",
                    folder.path,
                    checkpoint.neve,
                    version(),
                )
            interrupt = stack.enter_context(Interrupt(quiet))
            reached = _loop(sim, done, last, outputs, progress, interrupt)
            if reached < last:
                raise KeyboardInterrupt(
                    f"stopped after frame {reached} of {last}; go on with: neve run {folder.path} --resume"
                )
            progress.say(f"{folder.path}: frames 0 to {last} are done")
    return sim


def _loop(
    sim: Simulation,
    done: int | None,
    last: int,
    outputs: Sequence[Output],
    progress: Progress,
    interrupt: Interrupt,
) -> int:
    """Advance frame by frame, stop between frames when the user asks, and return the last frame done.

    A checkpoint says that its frame is complete: it is written last of a frame and closed first of all.
    """
    timer = StageTimer()
    frame = 0 if done is None else done
    context = FrameContext(sim, frame, last, timer)
    if done is None:
        _show(context, outputs)
    progress.update(frame, sim.state.count, sim.steps)
    while frame < last and not interrupt.requested:
        sim.advance(1.0 / sim.scene.run.fps)
        frame += 1
        context = FrameContext(sim, frame, last, timer)
        _show(context, outputs)
        progress.update(frame, sim.state.count, sim.steps)
    for output in reversed(outputs):
        output.close(context)
    return frame


def _show(context: FrameContext, outputs: Sequence[Output]) -> None:
    for output in outputs:
        if output.schedule.due(context.frame):
            output.write(context)


def _check_same(folder: Path, before: str, now: str) -> None:
    """Refuse to go on in a run with another scene: its frames would belong to neither."""
    old, new = (dict(_flatten(tomllib.loads(text))) for text in (before, now))
    for key in sorted(old.keys() | new.keys()):
        free = any(key == name or key.startswith(f"{name}.") for name in _FREE)
        if not free and old.get(key) != new.get(key) and not same_content(old.get(key), new.get(key)):
            was, wish = (repr(table[key]) if key in table else "absent" for table in (old, new))
            raise RunError(
                f"{folder} was made with another scene ({key} is {was} there and {wish} now):"
                " resume it unchanged, start anew with --force, or choose another --out."
            )


def _looks(toml: str) -> object:
    tables = tomllib.loads(toml)
    return tables.get("camera"), tables.get("light")


def _flatten(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield every leaf of nested tables and lists of tables with its dotted path."""
    if isinstance(value, Mapping):
        items: list[tuple[str, object]] = [(str(key), inner) for key, inner in value.items()]
    elif isinstance(value, list) and any(isinstance(inner, Mapping) for inner in value):
        items = [(str(index), inner) for index, inner in enumerate(value)]
    else:
        yield path, value
        return
    for key, inner in items:
        yield from _flatten(inner, f"{path}.{key}" if path else key)
