"""The folder of an export: what is in it, so that an export can go on, begin anew, and touch nothing else."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from neve.export.format import replacing, writing
from neve.io.errors import RunError, cannot_read
from neve.io.export_card import LAYOUT, NAME, read_record
from neve.io.run_folder import RunFolder
from neve.system import disk

PAUSE = 2.0
"""Wall time between two writes of the card [s]; a kill costs what was exported since, no more."""


class ExportFolder:
    """Keep a record of an export in its folder: options, files, and which frames are there.

    Only files of the record are ever deleted, and no other file is written over.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.card = path / NAME
        self._options: dict[str, Any] = {}
        self._files: set[str] = set()
        self._frames: dict[int, tuple[float, int]] = {}
        self._written = 0.0

    def open(self, options: Mapping[str, Any], force: bool, stems: Collection[str] | None = None) -> None:
        """Make the folder ready for an export with these `options`: new, continued, or emptied by `force`.

        stems: see `check`

        Errors: RunError: as of `check`, or the disk refuses.
        """
        found = self.check(options, force, stems)
        with writing(self.path):
            disk.make_folder(self.path)
            disk.sweep(self.path)
            if found is not None and force:
                disk.remove_files(self.path, [*found["files"], NAME])
                found = None
        self._options = dict(options)
        if found is not None:
            self._files = set(found["files"])
            self._frames = {int(k): (float(t), int(mark)) for k, (t, mark) in found["frames"].items()}
        self.save()

    def check(
        self, options: Mapping[str, Any], force: bool, stems: Collection[str] | None = None
    ) -> dict[str, Any] | None:
        """Return the record of the export that lies here, None if there is none; change nothing.

        stems: how names of files of the export begin; a new export may lie beside others. None: beside none

        Errors: RunError: the folder holds an export with other options, or other files.
        """
        if os.path.lexists(self.path) and not self.path.is_dir():
            raise RunError(f"{self.path} is a file, and an export needs a folder: choose another --out.")
        found = read_record(self.path)
        if found is None:
            self._refuse_strangers(stems)
        elif not force and found["options"] != dict(options):
            raise RunError(
                f"{self.path} holds an export with {_difference(found['options'], options)}: replace it with"
                " --force, or choose another --out."
            )
        return found

    def has(self, frame: int, mark: int, names: Iterable[str]) -> bool:
        """Return whether a frame is here, made from the frame file with this `mark` (see `neve.io.npz`)."""
        known = self._frames.get(frame)
        return known is not None and known[1] == mark and self.lies(names)

    def lies(self, names: Iterable[str]) -> bool:
        """Return whether all these files are here."""
        return all(self._lies(name) for name in names)

    def times(self) -> dict[int, float]:
        """Return the times [s] of the frames that are here, by number, in order."""
        return {frame: self._frames[frame][0] for frame in sorted(self._frames)}

    def announce(self, names: Iterable[str]) -> None:
        """Take note of files that are about to be written."""
        self._files |= {*names}

    def add(self, frame: int, time_: float, mark: int) -> None:
        """Take note that the files of a frame are there."""
        self._frames[frame] = (time_, mark)
        if time.monotonic() > self._written + PAUSE:
            self.save()

    def forget(self) -> None:
        """Take note that no frame is there any more."""
        self._frames = {}

    def drop_after(self, last: int, names: Callable[[int], Iterable[str]]) -> None:
        """Remove the frames later than `last`; names: of the files of a frame. Errors: RunError."""
        self._drop([frame for frame in self._frames if frame > last], names)

    def keep(self, marks: Mapping[int, int], names: Callable[[int], Iterable[str]]) -> None:
        """Remove the frames made from other frame files than those of `marks`; names: see `drop_after`.

        A frame with the mark 0 was never kept as a file, so that nothing can tell it is another's.

        Errors: RunError.
        """
        self._drop([n for n, (_, mark) in self._frames.items() if mark != marks.get(n, 0)], names)

    def _drop(self, frames: Sequence[int], names: Callable[[int], Iterable[str]]) -> None:
        gone = {name for frame in frames for name in names(frame)}
        with writing(self.path):
            disk.remove_files(self.path, gone)
        self._files -= gone
        for frame in frames:
            del self._frames[frame]

    def save(self) -> None:
        """Write the record. Errors: RunError."""
        card = {
            "layout": LAYOUT,
            "options": self._options,
            "files": sorted(self._files),
            "frames": {str(k): list(self._frames[k]) for k in sorted(self._frames)},
        }
        with replacing(self.card) as file:
            file.write(json.dumps(card).encode())
        self._written = time.monotonic()

    def _refuse_strangers(self, stems: Collection[str] | None) -> None:
        try:
            names = [path.name for path in self._contents() if not disk.is_temporary(path.name)]
            if stems is not None:
                names = [name for name in names if stem(name) in stems]
        except OSError as error:
            raise cannot_read(self.path, error) from error
        if names:
            what = "a run" if RunFolder(self.path).is_run() else "files that are no export"
            raise RunError(f"{self.path} holds {what}: choose another --out.")

    def _contents(self) -> Iterator[Path]:
        return self.path.iterdir() if self.path.is_dir() else iter(())

    def _lies(self, name: str) -> bool:
        path = self.path / name
        return path.is_file() and not path.is_symlink()


def stem(name: str) -> str:
    """Return how the name of a file of an export begins: "snow" of snow_000012.ply and of snow.pvd."""
    return name.partition(".")[0].rpartition("_")[0] or name.partition(".")[0]


def _difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """Say in which option two exports differ first, as the old one has it."""
    for name in (*old, *new):
        if old.get(name) != new.get(name):
            value = old.get(name)
            return f"{name} = {', '.join(map(str, value)) if isinstance(value, list) else value}"
    return "other options"
