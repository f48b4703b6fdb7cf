"""Tables of a run that grow frame by frame: CSV files, ready for a spreadsheet or pandas."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from neve.io.atomic import write_text, writing
from neve.io.errors import RunError, cannot_read
from neve.system import disk


class Table:
    """Append rows to a CSV file, each batch with one write that is taken back if it fails.

    Errors: RunError if the disk refuses, or if the file has other columns (an older or newer Neve wrote it).
    """

    def __init__(self, path: Path, columns: tuple[str, ...], keep_through: int | None = None) -> None:
        """Start a new table, or keep the rows up to frame `keep_through` of the one that lies there.

        columns: names; one of them is `frame`
        """
        self.path = path
        self.columns = columns
        rows: list[dict[str, str]] = []
        if keep_through is not None and path.exists():
            rows = [row for row in read_table(path, columns) if int(row["frame"]) <= keep_through]
        self.last = rows[-1] if rows else None
        """The last row that was kept."""
        write_text(path, table_text(columns, rows))

    def append(self, *rows: Mapping[str, object]) -> None:
        """Add rows; each has a value for every column (None leaves the cell empty)."""
        data = "".join(_line(self.columns, row) for row in rows).encode()
        with writing(self.path):
            disk.append(self.path, data)


def table_text(columns: tuple[str, ...], rows: Iterable[Mapping[str, object]]) -> str:
    """Return the text of a whole table: the names of the columns, then a line for each row."""
    head = dict(zip(columns, columns, strict=True))
    return "".join(_line(columns, row) for row in (head, *rows))


def read_table(path: Path, columns: tuple[str, ...]) -> list[dict[str, str]]:
    """Return the whole rows of a table as text, by column; a last line cut short by a crash is left out.

    Errors: RunError if the file cannot be read or has other columns.
    """
    try:
        text = disk.read_bytes(path).decode("utf-8", errors="replace")
    except OSError as error:
        raise cannot_read(path, error) from error
    lines = text[: text.rfind("\n") + 1].splitlines()
    table = list(csv.reader(lines))
    if not table or tuple(table[0]) != columns:
        kind = path.stem
        raise RunError(
            f"{path} is no {kind} of this version of Neve, so its rows cannot be continued: move it away (the"
            f" new {kind} starts without them), or start over with --force."
        )
    rows = [dict(zip(columns, cells, strict=True)) for cells in table[1:] if len(cells) == len(columns)]
    return [row for row in rows if row["frame"].isdecimal()]


def _line(columns: tuple[str, ...], row: Mapping[str, object]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerow([_cell(row[name]) for name in columns])
    return buffer.getvalue()


def _cell(value: object) -> str:
    """Write a number so that it reads back as the same number, and None or NaN as an empty cell."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
