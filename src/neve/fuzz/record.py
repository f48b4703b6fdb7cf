"""The file of a campaign: a head and a line of JSON for each outcome, written as they come."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import BinaryIO

import neve
from neve.fuzz.outcome import Outcome, outcome_of
from neve.io.errors import RunError, cannot_read, cannot_write
from neve.io.version import version


class Record:
    """Outcomes in the file `path`: those that it holds already, and those that are added.

    A last line that was cut off is dropped. Errors: RunError if the file is none of this campaign, was
    written by other code than this, or cannot be read or written.
    """

    def __init__(self, path: Path, campaign: str) -> None:
        self.path = path
        self.done: dict[tuple[int, int], Outcome] = {}
        head = {"neve_fuzz": campaign, "version": version(), "code": code()}
        try:
            text = path.read_bytes() if path.exists() else b""
        except OSError as error:
            raise cannot_read(path, error) from error
        whole = text[: text.rfind(b"\n") + 1]
        if text and not whole and not f"{json.dumps(head)}\n".encode().startswith(text):
            raise RunError(f"{path} is no file of outcomes of neve fuzz: name another.")
        self._read(whole, head)
        self._file = self._open(len(whole))
        if not whole:
            self._write(json.dumps(head))

    def _read(self, text: bytes, head: dict[str, str]) -> None:
        lines = text.decode(errors="replace").splitlines()
        for number, line in enumerate(lines, 1):
            try:
                if number == 1:
                    self._check(json.loads(line), head)
                else:
                    outcome = outcome_of(line)
                    self.done[outcome.seed, outcome.number] = outcome
            except (ValueError, RecursionError) as error:
                raise RunError(
                    f"{self.path}, line {number}, is no outcome of neve fuzz: name another file."
                ) from error

    def _check(self, found: object, head: dict[str, str]) -> None:
        if not isinstance(found, dict) or "neve_fuzz" not in found:
            raise ValueError("no head")
        if found["neve_fuzz"] != head["neve_fuzz"]:
            raise RunError(
                f"{self.path} holds outcomes of neve fuzz {found['neve_fuzz']}: name another file."
            )
        if found != head:
            raise RunError(f"{self.path} was written by another state of Neve's code: name another file.")

    def _open(self, size: int) -> BinaryIO:
        try:
            file = open(self.path, "ab")  # noqa: SIM115 (closed by close())
            file.truncate(size)
        except OSError as error:
            raise cannot_write(self.path, error) from error
        return file

    def add(self, outcome: Outcome) -> None:
        """Write an outcome at once."""
        self.done[outcome.seed, outcome.number] = outcome
        self._write(outcome.as_json())

    def _write(self, line: str) -> None:
        try:
            self._file.write(f"{line}\n".encode())
            self._file.flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def code() -> str:
    """Return a digest of the package's Python and compiled code."""
    digest = hashlib.sha256()
    for path in sorted(path for folder in set(neve.__path__) for path in Path(folder).rglob("*")):
        if path.suffix in (".py", ".so", ".pyd", ".toml"):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
