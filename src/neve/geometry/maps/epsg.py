"""Find the units of coordinate systems by their number in the EPSG Geodetic Parameter Dataset."""

from __future__ import annotations

from bisect import bisect_right
from functools import lru_cache
from pathlib import Path

TABLE = Path(__file__).parents[2] / "assets" / "epsg_units.txt"


def units_by_code(code: int) -> tuple[float | None, float | None]:
    """Return the units of lengths and of heights of the system `code` [m]; None where it does not say.

    The table has the systems whose units are not metres, and heights that are stated.
    """
    firsts, rows = _table()
    at = bisect_right(firsts, code) - 1
    if at < 0 or code > rows[at][0]:
        return None, None
    return rows[at][1:]


@lru_cache
def _table() -> tuple[list[int], list[tuple[int, float | None, float | None]]]:
    firsts, rows = [], []
    for line in TABLE.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            first, last, *units = line.split()
            flat, high = (None if unit == "-" else float(unit) for unit in units)
            firsts.append(int(first))
            rows.append((int(last), flat, high))
    return firsts, rows
