"""Find the units of a coordinate system that is written as text (well-known text, or Esri's older words)."""

from __future__ import annotations

import re
from dataclasses import dataclass

UNIT = re.compile(r'(?:LENGTH)?UNIT\s*\[\s*"[^"]*"\s*,\s*([-+0-9.eE]+)', re.IGNORECASE)
VERTICAL = re.compile(r"VERT(?:_CS|CS|CRS|ICALCRS)\s*\[", re.IGNORECASE)
PROJECTED, GEOGRAPHIC = (
    re.compile(r"PROJ(?:CS|CRS|ECTEDCRS)", re.I),
    re.compile(r"GEOGCS|GEO[GD]\w*CRS", re.I),
)
OLDER = re.compile(r"^\s*(Z?UNITS)\s+(\S+)", re.IGNORECASE | re.MULTILINE)
WORDS = {"METERS": 1.0, "METRES": 1.0, "METER": 1.0, "FEET": 0.3048006096012192, "INTFEET": 0.3048}
"""Units of Esri's older files [m]; FEET are feet of the US survey (1200 / 3937 m)."""


@dataclass(frozen=True)
class Units:
    """Hold the units of a coordinate system [m].

    Attributes:
        horizontal: None for degrees
        vertical: of heights; metres if the file does not say
        doubts: ends of sentences to warn of
    """

    horizontal: float | None = 1.0
    vertical: float = 1.0
    doubts: tuple[str, ...] = ()


def silent_heights(horizontal: float | None) -> tuple[str, ...]:
    """Return the doubt about heights without a unit beside lengths that are not metres."""
    if horizontal is None or abs(horizontal - 1.0) < 1e-3:
        return ()
    return (
        f"measures lengths in units of {horizontal:.6g} m and does not say in which its heights are: they "
        "are read as metres (of feet, height is to be 0.3048 times as large)",
    )


def units_of(text: bytes) -> Units:
    """Return the units that the text of a coordinate system states; metres where it says nothing."""
    words = text.decode("latin-1")
    older = {name.upper(): word.upper() for name, word in OLDER.findall(words)}
    if older:
        horizontal = (
            None if older.get("UNITS") in ("DD", "DS") else WORDS.get(older.get("UNITS", "METERS"), 1.0)
        )
        vertical = WORDS.get(older.get("ZUNITS", ""))
    else:
        flat, *upright = VERTICAL.split(words, maxsplit=1)
        found, high = UNIT.findall(flat), UNIT.findall(upright[0]) if upright else []
        is_flat = PROJECTED.search(flat) or not GEOGRAPHIC.search(flat)
        horizontal = (_number(found[-1]) if found else 1.0) if is_flat else None
        vertical = _number(high[-1]) if high else None
    if vertical is None:
        return Units(horizontal, 1.0, silent_heights(horizontal))
    return Units(horizontal, vertical)


def _number(word: str) -> float:
    try:
        found = float(word)
    except ValueError:
        return 1.0
    return found if 0.0 < found < 1e6 else 1.0
