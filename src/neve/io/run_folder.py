"""The folder of a run: what lies where in it, how it is recognised, made, resumed and replaced."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from neve.io.assets import FOLDER as ASSETS
from neve.io.atomic import sweep, write_text
from neve.io.errors import RunError, cannot_read, cannot_write
from neve.io.frames import frame_numbers, frame_path

FORMAT = 2
"""Version of the folder's layout; `run.json` carries it."""


class RunFolder:
    """Name the files of a run and keep folders that are no run from being touched.

    A folder is a run if it holds `run.json`, which also lists the files that the run's outputs write. Nothing
    but these and the files named here is ever deleted.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self.card = self.path / "run.json"  # format version, the Neve that made the run, files of its outputs
        self.scene = self.path / "scene.toml"
        self.assets = self.path / ASSETS  # what the scene names, see neve.io.assets
        self.log = self.path / "log.csv"
        self.frames = self.path / "frames"
        self.checkpoint = self.path / "checkpoint"

    def is_run(self) -> bool:
        """Tell whether a Neve run lies here."""
        return self.card.is_file()

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
            occupied = exists and any(self.path.iterdir())
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

        Errors: RunError, one sentence: the folder holds a run and neither word was given, holds other files,
        or comes from another version, or the disk refuses.
        """
        self.check(resume, force)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            if force and self.is_run():
                self._clear(files)
            self.frames.mkdir(exist_ok=True)
            sweep(self.path)
            sweep(self.frames)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        if not resume:
            write_text(self.card, json.dumps({"run_format": FORMAT, "neve": neve, "files": []}) + "\n")
        self.own(*files)

    def own(self, *names: str) -> None:
        """Add files to those that belong to the run, so that replacing the run removes them.

        Errors: RunError if the disk refuses.
        """
        card = self._read_card()
        files = sorted({*_plain(card.get("files")), *names})
        if files != card.get("files"):
            write_text(self.card, json.dumps({**card, "files": files}) + "\n")

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
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.path, os.O_RDONLY)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        try:
            self._take(lambda: fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB))
            yield
        finally:
            os.close(handle)
            if is_new:
                with contextlib.suppress(OSError):  # a run that never began leaves no empty folder
                    self.path.rmdir()

    def drop_frames_after(self, frame: int) -> None:
        """Remove the frames later than `frame`: they were written after the last checkpoint.

        Errors: RunError if the disk refuses.
        """
        try:
            for number in frame_numbers(self.frames):
                if number > frame:
                    frame_path(self.frames, number).unlink()
        except OSError as error:
            raise cannot_write(self.frames, error) from error

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
        if force:
            return
        if not resume:
            raise RunError(
                f"{self.path} already holds a run: continue it with --resume, replace it with --force,"
                " or choose another --out."
            )
        version = self._version()
        if version != FORMAT:
            older = "an older" if version < FORMAT else "a newer"
            raise RunError(
                f"{self.path} was written by {older} version of Neve (run format {version}; this one reads"
                f" {FORMAT}): use that version or start over with --force."
            )

    def _version(self) -> int:
        try:
            return int(self._read_card()["run_format"])
        except (ValueError, KeyError, TypeError) as error:
            raise self._damaged() from error

    def _read_card(self) -> dict[str, Any]:
        """Return what `run.json` says. Errors: RunError."""
        try:
            card: dict[str, Any] = json.loads(self.card.read_text(encoding="utf-8"))
            return {**card}
        except OSError as error:
            raise cannot_read(self.card, error) from error
        except (ValueError, TypeError) as error:
            raise self._damaged() from error

    def _damaged(self) -> RunError:
        return RunError(f"{self.card} is damaged; start over with --force or choose another --out.")

    def _clear(self, files: Iterable[str]) -> None:
        """Delete the run's own files, `run.json` last, so that a half-cleared folder is still a run.

        Its assets stay until those of the new run are there: they may be the same.
        """
        with contextlib.suppress(RunError):  # a damaged card lists nothing
            files = {*files, *_plain(self._read_card().get("files"))}
        for path in (self.checkpoint, self.log, self.scene, *map(self.path.joinpath, files)):
            if not path.is_dir():
                path.unlink(missing_ok=True)
            parts = path.with_name(f".{path.name}.parts")  # of a film that is not finished
            if parts.is_dir():
                shutil.rmtree(parts)
        self.drop_frames_after(-1)
        with contextlib.suppress(OSError):  # the user's own files in it stay, and the folder with them
            self.frames.rmdir()
        self.card.unlink()


def _plain(names: object) -> list[str]:
    """Return those of `names` that name a file in the folder itself."""
    given = names if isinstance(names, list) else []
    return [name for name in given if isinstance(name, str) and Path(name).name == name]
