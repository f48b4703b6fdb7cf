"""Format: what writes moments of a run as files of one kind."""

from __future__ import annotations

import contextlib
import functools
import importlib
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, ClassVar, Self

from neve.colliders.solid import Solid
from neve.export.axes import Axes, Up
from neve.export.camera import FilmCamera
from neve.export.moment import Moment
from neve.export.solids import SolidSurface, surfaces
from neve.io.errors import RunError, reason
from neve.system import disk

NAME = "snow"
"""How the names of all files of snow begin."""


@dataclass(frozen=True)
class Job:
    """Hold what is the same in all moments of an export.

    Attributes:
        folder: where the files belong
        solids: colliders and bodies, in the order of the poses of a moment
        axes: of the files
        fps: frames in a simulated second [1/s]
        spacing: distance of two particles that touch at rest, in the unit of the files
        dx: spacing of the simulation's grid, likewise
        title: of the run, in one line
        camera: of the scene
    """

    folder: Path
    solids: tuple[Solid, ...]
    axes: Axes
    fps: int
    spacing: float
    dx: float
    title: str
    camera: FilmCamera


class Format(ABC):
    """Write moments as files; one instance for one export, which is used in a `with` block.

    A subclass has a word in `neve.export.registry.FORMATS`. Every file appears whole or not at all.
    """

    ending: ClassVar[str] = ""
    """How the names of its files end, where a frame has one file of its own."""
    up: ClassVar[Up] = "z"
    """The axis that points up unless another is asked for: as programs that read the format expect."""
    takes_fields: ClassVar[bool] = True
    """Whether it has fields of particles."""
    takes_matrices: ClassVar[bool] = True
    """Whether a field may be a matrix."""
    weighs: ClassVar[bool] = False
    """Whether it needs the masses of the particles."""
    whole: ClassVar[bool] = False
    """Whether one file holds all frames: then it is written anew when any frame is missing in it."""
    package: ClassVar[tuple[str, str] | None] = None
    """A module that it needs beside Neve, and the name of the package that has it."""

    def __init__(self, job: Job) -> None:
        """Prepare. Errors: RunError if a package is missing."""
        self.job = job
        if self.package is not None:
            require(*self.package)

    @functools.cached_property
    def solids(self) -> list[tuple[int, SolidSurface]]:
        """The solids that can be seen, in units of the file, each with its place in the list of the job."""
        return surfaces(self.job.solids, self.job.axes.scale)

    def names(self, frame: int) -> tuple[str, ...]:
        """Return the names of the files of a frame; of a `whole` format, that of its file."""
        return (f"{NAME}_{frame:06d}.{self.ending}",)

    def begin(self, frames: Sequence[int]) -> None:
        """Prepare to write these frames, in this order; called before the first of them."""
        return

    @abstractmethod
    def write(self, moment: Moment) -> None:
        """Write the files of a frame. Errors: RunError if the disk refuses."""

    def shared_names(self) -> tuple[str, ...]:
        """Return the names of the files that `close` writes."""
        return ()

    def close(self, times: Mapping[int, float]) -> None:
        """Write what belongs to all frames; times: of those whose files are there [s], by number."""
        return

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return

    def path(self, name: str) -> Path:
        """Return the path of a file of the export."""
        return self.job.folder / name


def require(module: str, package: str) -> Any:
    """Import `module`. Errors: RunError that says how to install what is missing."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise RunError(f"this format needs the package {package}: pip install {package}.") from None


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """Open a file that takes the place of `path` when the block ends well. Errors: RunError."""
    with writing(path), disk.replacing(path) as file:
        yield file


@contextlib.contextmanager
def made_by_library(path: Path) -> Iterator[Path]:
    """Yield a path of the same ending for a library to write to, which then takes the place of `path`.

    Errors: RunError.
    """
    with writing(path), disk.made_by_library(path) as place:
        yield place


@contextlib.contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn what the system refuses in the block into one sentence about `path`. Errors: RunError."""
    try:
        yield
    except OSError as error:
        raise RunError(
            f"{path} could not be written: {reason(error)}; what is exported already is whole, and the same "
            "command goes on from there."
        ) from error
