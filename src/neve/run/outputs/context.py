"""What an output is given: the run when it begins, and each frame when it is due."""

from __future__ import annotations

import logging
import re
import threading
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

from neve.io.errors import RunError
from neve.io.frames import (
    Frame,
    block_edge,
    fields_of,
    frame_of,
    frame_of_stored,
    frame_path,
    stored,
    write_stored,
)
from neve.io.inventory import Inventory
from neve.io.npz import mark_of
from neve.io.table import Table
from neve.run.beside import Beside, Job
from neve.scene.schema.outputs import LONGEST
from neve.schedule import Regular

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.io.run_folder import RunFolder
    from neve.scene.schema.scene import Camera, Scene
    from neve.schedule import Schedule
    from neve.simulation import Simulation
    from neve.stage_timer import StageTimer


Made = TypeVar("Made")


class Output(Protocol):
    """Something that is written during a run.

    An output may also have `begin(run, schedule)`, which is called before the first frame (see `Begins`), a
    `schedule` of its own (every frame by default), and be a context manager, which the run then is inside of.
    """

    def write(self, context: FrameContext) -> None:
        """Write what belongs to this frame; called when the schedule says so."""
        ...

    def close(self, context: FrameContext) -> None:
        """Finish after the last frame, or after the frame in which the user stopped the run."""
        ...


def warn_of_lost(path: Path, frames: Sequence[int]) -> None:
    """Log that `path` lacks frames for good, if it does."""
    if frames:
        logging.getLogger("neve").warning(
            "%s lacks frame %d and %d more, which the run keeps no files of",
            path,
            frames[0],
            len(frames) - 1,
        )


@runtime_checkable
class Begins(Protocol):
    """An output that needs to know the run before its first frame."""

    def begin(self, run: RunContext, schedule: Schedule) -> None:
        """Prepare the files, and continue those of a run that is resumed."""
        ...


@runtime_checkable
class Resumes(Protocol):
    """An output that mends its files when a run is resumed, from the state at its last frame."""

    def resume(self, context: FrameContext) -> None:
        """Write anew what was lost of this frame, which is done already, and of those before it."""
        ...


@dataclass
class RunContext:
    """The run that an output belongs to.

    Attributes:
        folder: the run folder, ready to be written
        scene: what is simulated. toml: the same as it stands in the folder
        neve: version and build of Neve
        solids: colliders and bodies of the scene
        done: the last frame of a run that is resumed; None if it begins
        redraw: whether camera or light have changed since the frames up to `done` were drawn
        threads: threads to draw with; None: all
        radius: of a particle [m], as the solver has it; None: as the scene says
        reserved: names of files that no table of one's own may have
        inventory: what the run had written when its checkpoint was, if that is known; kept up to date by
            `write_frame` and `table`
        beside: does what is written while the next frame is computed
    """

    folder: RunFolder
    scene: Scene
    toml: str
    neve: str
    solids: Sequence[Solid]
    done: int | None
    redraw: bool = False
    threads: int | None = None
    radius: float | None = None
    reserved: Collection[str] = ()
    inventory: Inventory | None = None
    beside: Beside = field(default_factory=Beside)
    _frames: dict[int, int] = field(default_factory=dict)
    _tables: dict[str, Table] = field(default_factory=dict)

    def frames_done(self, schedule: Schedule) -> list[int]:
        """Return the frames up to `done` at which `schedule` was due, in order."""
        if self.done is None or not isinstance(schedule, Regular):
            return []
        return [k for k in range(self.done + 1) if schedule.due(k)]

    def marks(self) -> dict[str, tuple[int, int]]:
        """Return the marks of the tables, as they are now."""
        before = self.inventory or Inventory()
        return before.tables | {name: table.mark for name, table in self._tables.items()}

    def now(self, tables: dict[str, tuple[int, int]]) -> Inventory:
        """Return the inventory of the frames that are written now, and of tables with these marks."""
        before = self.inventory or Inventory()
        return Inventory(before.frames | self._frames, tables)

    def is_as_written(self, frame: int) -> bool:
        """Return whether the file of a frame is there, with the arrays that it had, as far as it is known."""
        wanted = None if self.inventory is None else self.inventory.frames.get(frame)
        try:
            mark = mark_of(frame_path(self.folder.frames, frame))
        except OSError:
            return False
        if mark is None or wanted not in (None, mark):
            return False
        self._frames[frame] = mark
        return True

    def write_frame(self, frame: int, arrays: Mapping[str, Any]) -> None:
        """Write a frame file of the run, with these arrays. Errors: RunError."""
        self._frames[frame] = write_stored(self.folder.frames, frame, arrays)

    def seen_from(self, camera: Camera | None) -> Scene:
        """Return the scene with another camera, or with its own."""
        return self.scene if camera is None else self.scene.model_copy(update={"camera": camera})

    def table(
        self,
        name: str,
        columns: tuple[str, ...],
        due: Iterable[int] = (),
        numbers: Collection[str] | None = None,
    ) -> Table:
        """Return the table `name` of the run folder, without rows after `done`.

        due: frames up to `done` that have rows, as far as it is known. numbers: see `Table`.

        Errors: RunError.
        """
        if name in self._tables and self._tables[name].columns != columns:
            had = ", ".join(self._tables[name].columns)
            raise RunError(f"{name} has the columns {had}: a row cannot have others ({', '.join(columns)}).")
        if name not in self._tables:
            self.folder.own(name)
            mark = None if self.inventory is None else self.inventory.tables.get(name)
            path = self.folder.path / name
            self._tables[name] = Table(path, columns, self.done, mark, list(due), numbers)
        return self._tables[name]


class FrameContext:
    """The end of a frame, as the outputs see it; they read and never change it.

    sim: the simulation. frame: number of the frame, 0 is the initial state. last: number of the last frame of
    the run. timer: adds up the wall time that writing and drawing take
    """

    def __init__(self, sim: Simulation, frame: int, last: int, timer: StageTimer, run: RunContext) -> None:
        self.sim = sim
        self.frame = frame
        self.last = last
        self.timer = timer
        self.run = run
        self._made: dict[str, Any] = {}
        self._making = threading.RLock()

    @property
    def finished(self) -> bool:
        """Whether this is the last frame of the run."""
        return self.frame == self.last

    @property
    def folder(self) -> Path:
        """The run folder."""
        return self.run.folder.path

    def beside(self, job: Job) -> int:
        """Do `job` while the next frame is computed, after what was handed over before; return its number.

        It may use what was copied, and nothing of the simulation, which goes on. Errors: what an earlier job
        raised.
        """
        return self.run.beside.do(self.frame, job)

    def take(self) -> None:
        """Copy the particles now, so that `stored` and `content` can be made of them beside the steps."""
        _ = self._moment

    @property
    def _moment(self) -> Frame:
        """A copy of the particles and solids now, in the order of their id."""
        return self._once("moment", self._copy)

    @property
    def stored(self) -> dict[str, Any]:
        """The arrays of the frame file."""
        return self._once("stored", lambda: stored(self._moment, block_edge(self.run.scene)))

    @property
    def content(self) -> Frame:
        """The particles and solids of this frame as its file says, so that all that shows them agrees."""
        return self._moment if "x" in self.stored else self._once("content", self._read_back)

    def _copy(self) -> Frame:
        poses = [(pose.position, pose.rotation) for _, pose in self.sim.solids()]
        columns = self.sim.columns()
        return frame_of(columns, poses, self.sim.time, fields_of(self.run.scene, columns))

    def _read_back(self) -> Frame:
        return frame_of_stored(self.stored)

    def _once(self, name: str, make: Callable[[], Made]) -> Made:
        """Return what `make` returned the first time, in whatever thread that was."""
        with self._making:
            if name not in self._made:
                self._made[name] = make()
            made: Made = self._made[name]
        return made

    def add_row(self, name: str, values: Mapping[str, object]) -> None:
        """Append a row to the CSV file `name` in the run folder: `frame`, `time` [s], then `values`.

        Each row is on disk when this returns. A resumed run drops the rows after its checkpoint and writes
        them again.

        Errors: RunError if the disk refuses, or if the file has other columns.
        """
        if name in self.run.reserved or not re.fullmatch(r"\w[\w.-]*", name) or len(name.encode()) > LONGEST:
            raise RunError(
                f'"{name}" cannot be a table of a run: choose another, of letters, digits and . _ -, at most'
                f" {LONGEST} bytes long."
            )
        if own := sorted({"frame", "time"} & {*values}):
            raise RunError(
                f"a row of {name} cannot have a value {own[0]} of its own: each row has it already."
            )
        row = {"frame": self.frame, "time": float(self.sim.time), **values}
        self.run.table(name, tuple(row), numbers=("frame", "time")).append(row)
