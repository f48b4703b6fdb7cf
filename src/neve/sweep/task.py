"""One run of a sweep, in whatever process it is done."""

from __future__ import annotations

import tomllib
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path

from neve.io.assets import assets_of, portable
from neve.io.atomic import write_text
from neve.io.checkpoint import read_checkpoint
from neve.io.errors import RunError
from neve.io.run_folder import RunFolder
from neve.run import last_frame, run_scene
from neve.run.resume import check_same
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Scene
from neve.solver import Blowup
from neve.sweep import spent
from neve.sweep.design import Point
from neve.sweep.measures import Measure, Own
from neve.sweep.table import DONE, FAILED, Row
from neve.system.cluster import threads_here


@dataclass(frozen=True)
class Task:
    """Hold one run: its scene, folder, and what to take from it.

    point: the inputs of its row. toml: the whole scene. threads: of the run; None for
    those of the process. frames: number of the last frame, None for the scene's duration
    force: replace the run that lies there
    """

    folder: Path
    point: Point
    toml: str
    measures: tuple[Measure, ...]
    functions: tuple[Own, ...] = ()
    threads: int | None = None
    frames: int | None = None
    force: bool = False

    @property
    def name(self) -> str:
        """The name of the run in the table."""
        return self.folder.name

    def read_scene(self) -> Scene:
        """Return the scene of the run. Errors: SceneError if this version of Neve cannot read it."""
        return scene_from(tomllib.loads(self.toml), where=self.name)

    def failed(self, sentence: str) -> Row:
        """Return the row of a run that has failed."""
        return Row(self.name, self.point, FAILED, " ".join(sentence.split()), self.seconds)

    @property
    def seconds(self) -> float:
        """The wall time that the run has taken so far [s]; NaN if it is not known."""
        found = spent.read(self.folder)
        return found.seconds if found else float("nan")


def carry_out(task: Task) -> Row:
    """Run, or go on with, one run of a sweep; return its row, which also tells what failed."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            scene = task.read_scene()
            if task.force or not is_done(task, scene):
                resume = not task.force and RunFolder(task.folder).has_begun()
                threads = task.threads or threads_here()
                with spent.counted(task.folder, last_frame(scene, task.frames), anew=not resume):
                    run_scene(scene, task.folder, threads, task.frames, resume, task.force, quiet=True)
        outputs = measured(task, scene)
    except (SceneError, RunError, Blowup, MemoryError, OSError) as error:
        sentence = "this needs more memory than there is." if isinstance(error, MemoryError) else str(error)
        return task.failed(sentence)
    except Exception as error:  # a fault of Neve or of a solver of the user's: the other runs go on
        trace = task.folder.with_name(f"{task.name}.error.txt")
        write_text(trace, traceback.format_exc())
        return task.failed(f"{type(error).__name__}: {error}; {trace.name} says where.")
    return Row(task.name, task.point, DONE, "", task.seconds, outputs)


def is_done(task: Task, scene: Scene) -> bool:
    """Tell whether the run is there up to its last frame. Errors: RunError for another or damaged run."""
    run, last = RunFolder(task.folder), last_frame(scene, task.frames)
    if not (run.is_run() and run.has_begun()):
        return False
    checkpoint = read_checkpoint(run.checkpoint)
    check_same(run.checkpoint, checkpoint.scene, portable(scene, assets_of(scene)))
    if checkpoint.frame > last:
        raise RunError(
            f"{run.path} goes on to frame {checkpoint.frame}, and --frames ends at {last}: leave --frames"
            " out, or choose another --out."
        )
    return checkpoint.frame == last


def measured(task: Task, scene: Scene) -> dict[str, float]:
    """Return the outputs of a finished run by name. Errors: RunError."""
    run = RunFolder(task.folder)
    found = {measure.name: measure.of(run, scene) for measure in task.measures}
    for own in task.functions:
        for name, value in own.of(run).items():
            if name in found or name in task.point:
                raise RunError(f"{own.path}:{own.function} returned {name}, which another column is called.")
            found[name] = value
    return found
