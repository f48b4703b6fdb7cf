"""The table of a sweep: a row for each run, as CSV and as Parquet."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from neve.io.atomic import replacing, write_text
from neve.io.errors import RunError, cannot_read
from neve.sweep.design import Point, toml_of
from neve.system import disk

CSV, PARQUET = "sweep.csv", "sweep.parquet"
DONE, FAILED, WAITING = "done", "failed", "waiting"
OWN = ("run", "status", "sentence", "seconds")
"""Columns of every sweep: the run's folder, a word from above, why it failed, wall time of the run [s]."""


@dataclass(frozen=True)
class Row:
    """Hold what came out of one run: its outputs by name or, in `sentence`, why there are none."""

    run: str
    point: Point
    status: str = WAITING
    sentence: str = ""
    seconds: float = math.nan
    outputs: dict[str, float] = field(default_factory=dict)

    def cells(self) -> dict[str, Any]:
        """Return the row by column."""
        inputs = {key: _input(value) for key, value in self.point.items()}
        own = {"status": self.status, "sentence": self.sentence, "seconds": self.seconds}
        return {"run": self.run, **inputs, **own, **self.outputs}


def _input(value: Any) -> Any:
    """Return a value as a table holds it: a list or a table as TOML."""
    return value if value is None or isinstance(value, (bool, int, float, str)) else toml_of(value)


def write(folder: Path, rows: Sequence[Row]) -> None:
    """Write both files, each whole or not at all. Without pyarrow only CSV. Errors: RunError."""
    cells = [row.cells() for row in rows]
    inputs = dict.fromkeys(key for row in rows for key in row.point)
    names = list(dict.fromkeys(["run", *inputs, *OWN[1:], *(name for row in cells for name in row)]))
    write_text(folder / CSV, _csv(names, cells))
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        return
    table = pa.table({name: pa.array(_column([row.get(name) for row in cells])) for name in names})
    with replacing(folder / PARQUET) as file:
        parquet.write_table(table, file)


def _csv(names: Sequence[str], cells: Sequence[dict[str, Any]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(names)
    for row in cells:
        writer.writerow(["" if is_empty(row.get(name)) else row[name] for name in names])
    return out.getvalue()


def is_empty(value: Any) -> bool:
    """Tell whether a cell stays empty."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def _column(values: list[Any]) -> list[Any]:
    """Return values of one type: numbers, or text."""
    values = [None if is_empty(value) else value for value in values]
    types = {type(value) for value in values if value is not None}
    if types == {int, float}:
        return [None if value is None else float(value) for value in values]
    return values if len(types) <= 1 else [None if value is None else str(value) for value in values]


def read(path: Path) -> list[dict[str, str]]:
    """Return the rows of a sweep's CSV, or of the one in the folder `path`, by column. Errors: RunError."""
    file = path / CSV if path.is_dir() else path
    try:
        text = disk.read_bytes(file).decode("utf-8-sig")
    except OSError as error:
        raise cannot_read(file, error) from error
    except UnicodeDecodeError as error:
        raise RunError(f"{file} is no table of a sweep: it is not text.") from error
    rows = list(csv.DictReader(io.StringIO(text)))
    if not rows or not {*OWN} <= {*rows[0]} or any(None in row or None in row.values() for row in rows):
        raise RunError(f"{file} is no table of a sweep: it has no columns {', '.join(OWN)}, or damaged rows.")
    return rows
