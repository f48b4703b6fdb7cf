"""The folder of a run: what lies where in it, how it is recognised, made, resumed and replaced."""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from neve.io import export_card
from neve.io.assets import FOLDER as ASSETS
from neve.io.atomic import writing
from neve.io.card import FORMAT, Card, read_card, write_card
from neve.io.errors import RunError, cannot_read
from neve.io.frames import frame_numbers, frame_path
from neve.io.links import refuse_link
from neve.system import disk

OLDER = ("bodies.csv",)
"""Files that a run of an older layout has and may not list."""


def parts_of(path: Path) -> Path:
    """Return the folder with what there is of the unfinished film `path`."""
    return path.with_name(f".{path.name}.parts")


class RunFolder:
    """Name the files of a run and keep folders that are no run from being touched.

    A folder is a run if it holds `run.json`, which also lists the files that the run's outputs write. Nothing
    but these and the files named here is ever written or deleted, and nothing outside the folder: a part of
    it that is a symbolic link to another folder is refused. `path` itself may be a link.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.card = self.path / "run.json"  # see neve.io.card
        self.scene = self.path / "scene.toml"
        self.assets = self.path / ASSETS  # what the scene names, see neve.io.assets
        self.log = self.path / "log.csv"
        self.frames = self.path / "frames"
        self.checkpoint = self.path / "checkpoint"

    def is_run(self) -> bool:
        """Tell whether a Neve run lies here."""
        return self.card.is_file()

    def has_begun(self) -> bool:
        """Tell whether a run lies here that has a first frame, or is damaged so that it cannot be told."""
        try:
            return self.is_run() and read_card(self.card).begun
        except RunError:
            return True

    def check(self, resume: bool = False, force: bool = False) -> None:
        """Refuse, in one sentence, what `open` would refuse; change nothing.

        Errors: RunError.
        """
        if resume and force:
            raise RunError("--resume continues a run and --force replaces it: choose one of the two.")
        try:
            exists = os.path.lexists(self.path)
            if exists and not self.path.is_dir():
                raise RunError(f"{self.path} is a file, and a run needs a folder: choose another --out.")
            occupied = exists and any(not disk.is_temporary(path.name) for path in self.path.iterdir())
            is_run = self.is_run()
        except OSError as error:
            raise cannot_read(self.path, error) from error
        if is_run:
            self._check_run(resume, force)
        elif resume:
            what = "holds no Neve run" if exists else "does not exist"
            raise RunError(f"{self.path} {what}, so there is nothing to resume.")
        elif occupied:
            never = " (--force replaces runs, never other files)" if force else ""
            raise RunError(f"{self.path} is not empty and is no Neve run{never}: choose another --out.")

    def open(self, neve: str, resume: bool = False, force: bool = False, files: Iterable[str] = ()) -> None:
        """Make the folder ready to be written: new, resumed (`resume`) or replaced (`force`).

        files: names of what the outputs of the run write

        A run that has not begun is replaced in any case. `run.json` is there before all else and until the
        end, so that whatever is left by a crash is a run.

        Errors: RunError, one sentence: the folder holds a run and neither word was given, holds other files,
        comes from another version, has links, or the disk refuses.
        """
        self.check(resume, force)
        files = {*files}
        replaced = self._files_of_old(files) if self.is_run() else set()
        resumed = resume and self.has_begun()
        self._check_inside(files)
        self._refuse_strangers(files - replaced)
        with writing(self.path):
            disk.make_folder(self.path)
            disk.sweep(self.path)
        if not resumed:
            write_card(self.card, Card(FORMAT, neve, tuple(files | replaced), begun=False))
            self._clear(replaced)
        with writing(self.frames):
            disk.make_folder(self.frames)
            disk.sweep(self.frames)
        if resumed:
            self.own(*files)
        else:
            write_card(self.card, Card(FORMAT, neve, tuple(files), begun=False))

    def begin(self) -> None:
        """Take note that the first frame and a checkpoint are written: from now on the run can be resumed.

        Errors: RunError if the disk refuses.
        """
        card = read_card(self.card)
        if not card.begun:
            write_card(self.card, dataclasses.replace(card, begun=True))

    def own(self, *names: str) -> None:
        """Add files to those that belong to the run, so that replacing the run removes them.

        Errors: RunError if the disk refuses, or a file of that name is there that is not the run's.
        """
        card = read_card(self.card)
        new = {*names} - {*card.files}
        if new:
            self._refuse_strangers(new)
            write_card(self.card, dataclasses.replace(card, files=(*card.files, *new)))

    @contextlib.contextmanager
    def lock(self) -> Iterator[None]:
        """Keep a second process from writing the same run; the lock goes when its process goes, however.

        Errors: RunError if another process runs here. Systems without `flock` get no lock.
        """
        try:
            import fcntl
        except ImportError:
            yield
            return
        is_new = not self.path.exists()
        with writing(self.path):
            disk.make_folder(self.path)
            handle = os.open(self.path, os.O_RDONLY)
        try:
            self._take(lambda: fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB))
            yield
        finally:
            os.close(handle)
            if is_new:
                disk.remove_if_empty(self.path)  # a run that never began leaves no empty folder

    def drop_frames_after(self, frame: int) -> None:
        """Remove the frames later than `frame`: they were written after the last checkpoint.

        Errors: RunError if the disk refuses.
        """
        refuse_link(self.path, self.frames)
        with writing(self.frames):
            late = [frame_path(self.frames, n).name for n in frame_numbers(self.frames) if n > frame]
            if late:
                disk.remove_files(self.frames, late)

    def _take(self, flock: Callable[[], None]) -> None:
        try:
            flock()
        except BlockingIOError as error:
            raise RunError(
                f"another process is running in {self.path}: wait for it or choose another --out."
            ) from error
        except OSError:
            return  # some network disks know no locks

    def _check_run(self, resume: bool, force: bool) -> None:
        self._check_inside(())
        if force:
            return
        begun = self.has_begun()
        if not resume and begun:
            raise RunError(
                f"{self.path} already holds a run: continue it with --resume, replace it with --force,"
                " or choose another --out."
            )
        version = read_card(self.card).format
        if version != FORMAT:
            older = "an older" if version < FORMAT else "a newer"
            raise RunError(
                f"{self.path} was written by {older} version of Neve (run format {version}; this one reads"
                f" {FORMAT}): use that version or start over with --force."
            )

    def _check_inside(self, files: Iterable[str]) -> None:
        """Refuse parts of the folder that lead out of it. Errors: RunError."""
        with contextlib.suppress(RunError):
            files = {*files, *read_card(self.card).files}
        for part in (self.frames, self.assets, *(parts_of(self.path / name) for name in files)):
            refuse_link(self.path, part)

    def _refuse_strangers(self, names: Iterable[str]) -> None:
        """Refuse to write over a file that is not the run's. Errors: RunError."""
        for name in sorted(names):
            path = self.path / name
            if name != self.frames.name and os.path.lexists(path):
                raise RunError(
                    f"{path} is no file of the run and would be overwritten: move it away, or choose another"
                    " name or --out."
                )

    def _files_of_old(self, usual: Iterable[str]) -> set[str]:
        """Return the names of the files of the run that lies here; of one that lists none, those `usual`."""
        own = {self.checkpoint.name, self.log.name, self.scene.name, self.frames.name}
        with contextlib.suppress(RunError):
            card = read_card(self.card)
            if card.files and card.format == FORMAT:
                return {*card.files, *own}
        return {*usual, *OLDER, *own}

    def _clear(self, files: Iterable[str]) -> None:
        """Delete the files of a run that is replaced.

        Its assets stay until those of the new run are there: they may be the same.
        """
        for path in map(self.path.joinpath, files):
            with writing(path):
                if path.is_symlink() or not path.is_dir():
                    disk.remove(path)
                else:
                    export_card.clear(path)
                disk.remove_tree(parts_of(path))
        self.drop_frames_after(-1)
        disk.remove_if_empty(self.frames)  # the user's own files in it stay, and the folder with them
