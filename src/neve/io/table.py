"""Tables of a run that grow frame by frame: CSV files, ready for a spreadsheet or pandas."""

from __future__ import annotations

import contextlib
import csv
import io
import logging
import math
import os
import re
import zlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path

from neve.io.atomic import write_text, writing
from neve.io.errors import RunError, cannot_read
from neve.system import disk

WORDS = ("bound", "kind", "solid")
"""Columns of Neve's own tables that hold words; all others hold numbers, or nothing."""

Row = dict[str, str]
Mark = tuple[int, int]
"""Number of rows and a CRC-32."""
_WHOLE = re.compile(r"[0-9]{1,15}")


class Table:
    """Append rows to a CSV file, each batch as a whole or not at all.

    Errors: RunError if the disk refuses, if the file has other columns (an older or newer Neve wrote it), or
    if it is damaged.
    """

    def __init__(
        self,
        path: Path,
        columns: tuple[str, ...],
        keep_through: int | None = None,
        mark: Mark | None = None,
        due: Sequence[int] = (),
        numbers: Collection[str] | None = None,
    ) -> None:
        """Start a new table, or keep the rows up to frame `keep_through` of the one that lies there.

        columns: names; one of them is `frame`
        mark: what `mark` was when the rows up to then were written, if it is known. If the file has changed
            since, rows that are doubled or out of order are put right, and the rest is told.
        due: frames that have rows, as far as it is known
        numbers: columns that hold numbers, by default all but those in WORDS
        """
        self.path = path
        self.columns = columns
        self.is_as_written = True
        """Whether nothing of the rows that were kept was lost or changed since they were written."""
        rows = [] if keep_through is None else self._kept(keep_through, mark, due, numbers)
        self.last = rows[-1] if rows else None
        """The last row that was kept."""
        self._mark: Mark = (0, 0)
        self._put(rows)

    @property
    def mark(self) -> Mark:
        """Number of rows, and the CRC-32 of all of them without wall times, which differ from run to run."""
        return self._mark

    def append(self, *rows: Mapping[str, object]) -> None:
        """Add rows; each has a value for every column (None leaves the cell empty)."""
        data = "".join(_line(self.columns, row) for row in rows).encode()
        with writing(self.path):
            disk.append(self.path, data)
        self._mark = _marked(self.columns, rows, self._mark)

    def replace(self, rows: Iterable[Mapping[str, object]]) -> None:
        """Put these rows in place of those of their frames, in the order of the frames."""
        new = [{name: _cell(row[name]) for name in self.columns} for row in rows]
        frames = {row["frame"] for row in new}
        kept = [row for row in read_table(self.path, self.columns) if row["frame"] not in frames]
        self._put(sorted([*kept, *new], key=_frame))

    def _put(self, rows: Sequence[Row]) -> None:
        write_text(self.path, table_text(self.columns, rows))
        self._mark = _marked(self.columns, rows)

    def _kept(
        self, through: int, mark: Mark | None, due: Sequence[int], numbers: Collection[str] | None
    ) -> list[Row]:
        """Return the rows up to frame `through`, and log what is wrong with them."""
        log = logging.getLogger("neve")
        if not os.path.lexists(self.path):
            if mark is not None and mark[0]:
                self.is_as_written = False
                log.warning("%s is gone: a new one begins after frame %d", self.path, through)
            return []
        untidy = "%s had rows that were doubled or out of order: they are put right"
        if mark is not None:
            first: list[Row] = []
            with contextlib.suppress(RunError):
                first = read_table(self.path, self.columns, numbers, most=mark[0])
            if _marked(self.columns, first) == mark:
                with contextlib.suppress(RunError):  # what comes later is written anew, whatever it is
                    more = read_table(self.path, self.columns, ())[mark[0] :]
                    if any(_frame(row) <= through for row in more):
                        log.warning(untidy, self.path)
                return first
        rows = [row for row in read_table(self.path, self.columns, numbers) if _frame(row) <= through]
        tidy = sorted({tuple(row.values()): row for row in rows}.values(), key=_frame)
        if tidy != rows:
            log.warning(untidy, self.path)
        is_changed = mark not in (None, _marked(self.columns, tidy))
        if missing := sorted({*due} - {_frame(row) for row in tidy}):
            others = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
            log.warning("%s lacks the rows of frame %d%s, which were lost", self.path, missing[0], others)
        elif is_changed:
            log.warning("%s is not as the run wrote it: its rows stay as they are", self.path)
        self.is_as_written = not missing and not is_changed
        return tidy


def _marked(columns: tuple[str, ...], rows: Iterable[Mapping[str, object]], mark: Mark = (0, 0)) -> Mark:
    """Return the mark of a table with the mark `mark` after `rows` were added."""
    count, crc = mark
    names = [name for name in columns if not name.startswith("seconds_")]
    for row in rows:
        count += 1
        crc = zlib.crc32("\x1f".join([*(_cell(row[name]) for name in names), ""]).encode(), crc)
    return count, crc


def _frame(row: Mapping[str, str]) -> int:
    return int(row["frame"])


def table_text(columns: tuple[str, ...], rows: Iterable[Mapping[str, object]]) -> str:
    """Return the text of a whole table: the names of the columns, then a line for each row."""
    head = dict(zip(columns, columns, strict=True))
    return "".join(_line(columns, row) for row in (head, *rows))


def read_table(
    path: Path, columns: tuple[str, ...], numbers: Collection[str] | None = None, most: int | None = None
) -> list[Row]:
    """Return the whole rows of a table as text, by column; a last line cut short by a crash is left out.

    numbers: columns that hold numbers, by default all but those in WORDS. most: read no more rows.

    Errors: RunError if the file cannot be read, has other columns, or holds what is no row.
    """
    try:
        text = disk.read_bytes(path).decode("utf-8-sig", errors="replace")
    except OSError as error:
        raise cannot_read(path, error) from error
    try:
        lines = list(csv.reader(io.StringIO(text[: text.rfind("\n") + 1], newline="")))
    except csv.Error as error:
        raise _damaged(path, 1) from error
    if not lines or tuple(lines[0]) != columns:
        kind = path.stem
        raise RunError(
            f"{path} is no {kind} of this version of Neve, so its rows cannot be continued: move it away (the"
            f" new {kind} starts without them), or start over with --force."
        )
    figures = [name for name in columns if name not in WORDS] if numbers is None else numbers
    rows: list[Row] = []
    for number, cells in enumerate(lines[1:], 2):
        if len(rows) == most:
            break
        if not cells:
            continue
        row = dict(zip(columns, cells, strict=False))
        if len(cells) != len(columns) or not _WHOLE.fullmatch(row["frame"]):
            raise _damaged(path, number)
        if not all(_is_number(row[name]) for name in figures if name in row):
            raise _damaged(path, number)
        rows.append(row)
    return rows


def _damaged(path: Path, line: int) -> RunError:
    return RunError(
        f"{path} is damaged (line {line} is no row of it): mend that line, move the file away (the new"
        f" {path.stem} starts without its rows), or start over with --force."
    )


def _is_number(cell: str) -> bool:
    try:
        float(cell or "0")
    except ValueError:
        return False
    return True


def _line(columns: tuple[str, ...], row: Mapping[str, object]) -> str:
    buffer = io.StringIO()
    ends = "\r\n"  # the writer quotes what stands in its own line ends: a name may hold either
    csv.writer(buffer, lineterminator=ends).writerow([_cell(row[name]) for name in columns])
    return buffer.getvalue().removesuffix(ends) + "\n"


def _cell(value: object) -> str:
    """Write a number so that it reads back as the same number, and None or NaN as an empty cell."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
