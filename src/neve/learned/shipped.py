"""The networks that come with Neve: their weights, and which snows they were trained for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from neve.learned.targets import TARGETS


def weights_file(law: str) -> Path:
    """Return where the weights of a law lie."""
    return Path(__file__).parent / "weights" / f"{law}.json"


@cache
def shipped(law: str) -> dict[str, Any]:
    """Return what `neve.learned.train` wrote for a law of `TARGETS`."""
    read: dict[str, Any] = json.loads(weights_file(law).read_text(encoding="utf-8"))
    return read


def weights_of(law: str) -> dict[str, list[float]]:
    """Return a, b, W, V, w, d and q of a law, row by row, as the core takes them."""
    found: dict[str, list[float]] = shipped(law)["weights"]
    return found


def untrained(law: str, plasticity: str, constants: Mapping[str, float]) -> tuple[str, str] | None:
    """Return the key of a snow that no network was trained for and what is allowed, or None."""
    if law not in TARGETS:
        return "law", "set " + " or ".join(f'"{name}"' for name in TARGETS)
    if plasticity != "snow":
        return "plasticity", 'set "snow"'
    for key, (low, high) in TARGETS[law].ranges.items():
        if not low <= constants[key] <= high:
            return key, f"set {low:g} to {high:g}"
    return None
