"""Append the JSON of `neve bench --json` (standard input) to a CSV file, one row per case.

neve bench 20k 200k --json | python benchmarks/to_csv.py benchmarks/results/MACHINE.csv
"""

from __future__ import annotations

import csv
import datetime
import json
import sys
from pathlib import Path
from typing import Any

MACHINE = ("cpu", "isa", "compiler", "python")
CASE = ("case", "particles", "threads", "precision", "spline", "transfer", "steps", "batches")
STAGES = ("stress", "sort", "p2g", "grid", "g2p", "ahead", "bodies", "other")
MEMORY = ("bytes_core", "bytes_resident", "blocks", "flowing")
SPREADS = ("step_ms", "rate", "frame_ms", "seconds")
COLUMNS = [
    "date",
    *MACHINE,
    *CASE,
    *(f"{stage}_ms" for stage in STAGES),
    *(f"{name}{part}" for name in SPREADS for part in ("", "_least", "_largest")),
    *MEMORY,
]


def row(machine: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Flatten one result."""
    cells = {name: machine.get(name) for name in MACHINE}
    cells |= {name: result.get(name) for name in (*CASE, *MEMORY)}
    cells |= {f"{stage}_ms": spread["median"] for stage, spread in result.get("stage_ms", {}).items()}
    for name in SPREADS:
        if spread := result.get(name):
            cells |= {
                name: spread["median"],
                f"{name}_least": spread["least"],
                f"{name}_largest": spread["largest"],
            }
    return {name: f"{cell:.6g}" if isinstance(cell, float) else cell for name, cell in cells.items()}


def main() -> None:
    """Read, flatten, append."""
    if len(sys.argv) != 2:
        raise SystemExit("usage: neve bench CASE... --json | python benchmarks/to_csv.py FILE.csv")
    path, found = Path(sys.argv[1]), json.load(sys.stdin)
    date = datetime.datetime.now(datetime.UTC).date().isoformat()
    new = not path.exists()
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            writer.writeheader()
        for result in found["results"]:
            writer.writerow({"date": date, **row(found["machine"], result)})


if __name__ == "__main__":
    main()
