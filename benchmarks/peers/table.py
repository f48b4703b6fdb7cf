"""The table of the comparison, as CSV and Markdown."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, fields


@dataclass(frozen=True)
class Row:
    """Hold one peer's line; what is not known is None.

    Attributes:
        peer, version, law, precision: words. particles: how many; dx [m]; dt: its own step [s]
        threads: that it was given; device: "cpu" or "cuda"
        rate: million particle-steps a second. wall: wall time of a simulated second [s]
        neve_wall: the same of Neve in turn with it [s]; ratio: wall over neve_wall, the median of the pairs;
        least, largest: of the pairs
        load: of the machine at the start, in processes that run
        note: what differs, or why there is nothing
    """

    peer: str
    version: str | None = None
    law: str | None = None
    precision: str | None = None
    particles: int | None = None
    dx: float | None = None
    dt: float | None = None
    threads: int | None = None
    device: str | None = None
    rate: float | None = None
    wall: float | None = None
    neve_wall: float | None = None
    ratio: float | None = None
    least: float | None = None
    largest: float | None = None
    load: float | None = None
    note: str = ""


@dataclass(frozen=True)
class About:
    """Hold what all rows share: date, hardware, the versions of Neve and Python, and the command."""

    date: str
    hardware: str
    neve: str
    python: str
    command: str


def as_csv(about: About, rows: Sequence[Row]) -> str:
    """Return the rows as CSV, each with what they share."""
    shared = [field.name for field in fields(About)]
    own = [field.name for field in fields(Row)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*shared, *own])
    for row in rows:
        writer.writerow(
            [getattr(about, name) for name in shared] + [_cell(getattr(row, name)) for name in own]
        )
    return text.getvalue()


COLUMNS = {
    "peer": lambda row: f"{row.peer} {row.version or ''}".strip(),
    "law": lambda row: row.law,
    "precision": lambda row: row.precision,
    "particles": lambda row: None if row.particles is None else f"{row.particles:,}",
    "dx [m]": lambda row: row.dx,
    "dt [s]": lambda row: row.dt,
    "threads": lambda row: row.threads,
    "M particle-steps/s": lambda row: row.rate,
    "wall s per simulated s": lambda row: row.wall,
    "over Neve's in turn": lambda row: (
        None if row.ratio is None else f"{row.ratio:.3g} ({row.least:.3g}-{row.largest:.3g})"
    ),
    "load": lambda row: None if row.load is None else f"{row.load:.1f}",
    "note": lambda row: row.note,
}


def as_markdown(about: About, rows: Sequence[Row]) -> str:
    """Return the rows as a table of Markdown, with what they share in a line before it."""
    lines = [
        f"{about.date}, {about.hardware}, Neve {about.neve}, Python {about.python}: `{about.command}`",
        "",
    ]
    lines.append("| " + " | ".join(COLUMNS) + " |")
    lines.append("|" + "---|" * len(COLUMNS))
    for row in rows:
        cells = (_cell(value(row)).replace("|", "/") for value in COLUMNS.values())
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
