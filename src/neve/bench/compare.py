"""Set measured speeds beside those of an earlier run: ratios, stage by stage."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from neve.io.errors import RunError, cannot_read

if TYPE_CHECKING:
    from neve.bench.run import Speed

SAME = ("case", "particles", "threads", "precision", "spline", "transfer")
"""What must be equal for two speeds to be compared."""


@dataclass(frozen=True)
class Earlier:
    """Hold the speed of one case as it was.

    Attributes:
        key: the values of SAME, as text
        told: when, on what and by which build it was measured, as far as the file says
        ms: median wall time of each stage of a step, and of the "step" [ms]
    """

    key: tuple[str, ...]
    told: str
    ms: Mapping[str, float]

    def lines(self, speed: Speed) -> list[str]:
        """Return the ratios of `speed` to this, now over then, as text."""
        now = {stage: spread.median for stage, spread in speed.stage_ms.items()} | {
            "step": speed.step_ms.median
        }
        ratios = [
            f"{stage} {now[stage] / then:.2f}" for stage, then in self.ms.items() if then > 0 and stage in now
        ]
        return [f"  time over that of {self.told}: " + ", ".join(ratios)]


def read_earlier(path: Path | str) -> list[Earlier]:
    """Return the speeds of a file of `neve bench --json`, or of benchmarks/to_csv.py, in its order.

    Errors: RunError if it cannot be read or holds none.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        found = _of_json(text) if text.lstrip().startswith("{") else _of_csv(text)
    except OSError as error:
        raise cannot_read(path, error) from error
    except (ValueError, TypeError, KeyError, AttributeError, csv.Error) as error:
        raise RunError(
            f"{path} holds no speeds: a file of `neve bench --json` or of benchmarks/results is needed"
        ) from error
    if not found:
        raise RunError(f"{path} holds no speed of a step")
    return found


def compared(speed: Speed, earlier: Sequence[Earlier]) -> list[str]:
    """Return `speed` beside the latest of `earlier` that is of the same case, as lines of text."""
    key = tuple(str(getattr(speed, name)) for name in SAME)
    same = [one for one in earlier if one.key == key]
    return same[-1].lines(speed) if same else ["  nothing to compare with: the file has no such case"]


def _of_json(text: str) -> list[Earlier]:
    found = json.loads(text)
    told = _told(found["machine"])
    return [
        Earlier(
            tuple(str(result[name]) for name in SAME),
            told,
            _times(
                {
                    stage: spread["median"]
                    for stage, spread in (*result["stage_ms"].items(), ("step", result["step_ms"]))
                }
            ),
        )
        for result in found["results"]
        if "stage_ms" in result
    ]


def _of_csv(text: str) -> list[Earlier]:
    rows = csv.DictReader(text.splitlines(), strict=True)
    end = "_ms"
    return [
        Earlier(
            tuple(row[name] for name in SAME),
            _told(row),
            _times(
                {
                    name.removesuffix(end): float(cell)
                    for name, cell in row.items()
                    if name.endswith(end) and name != "frame_ms" and cell
                }
            ),
        )
        for row in rows
        if row["step_ms"]
    ]


def _times(ms: Mapping[str, Any]) -> dict[str, float]:
    """Return times as numbers. Errors: ValueError for one that is none."""
    out = {stage: float(value) for stage, value in ms.items()}
    if not all(math.isfinite(value) and value >= 0 for value in out.values()):
        raise ValueError("a time that is no number")
    return out


def _told(machine: Mapping[str, Any]) -> str:
    parts = [str(machine[name]).strip() for name in ("date", "cpu", "isa", "compiler") if machine.get(name)]
    return ", ".join(parts) or "the file"
