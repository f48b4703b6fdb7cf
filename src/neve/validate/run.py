"""Run cases, print how they go, and write the report."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

from neve.io.atomic import write_text
from neve.io.errors import RunError
from neve.io.version import version
from neve.spelling import hint, nearest
from neve.system import processes
from neve.validate.registry import CASES
from neve.validate.report.page import page
from neve.validate.report.plots import require_matplotlib
from neve.validate.result import Result

REPORT = "validation.html"


def validate(
    names: Sequence[str] = (), out: str | None = None, as_json: bool = False, threads: int = 1
) -> bool:
    """Run the named cases (or all), print a line each, write the report; return whether all hold.

    `threads` cases run at once. The report goes to `out`, or to REPORT; with `as_json` results are printed as
    JSON and the page is written only if `out` is given. Neither depends on the time or the threads.

    Errors: RunError for a name that is no case, for plots without matplotlib, and for a page that cannot be
    written.
    """
    chosen = _chosen(names)
    writes_page = out is not None or not as_json
    if writes_page:
        require_matplotlib()
    stream = sys.stderr if as_json else sys.stdout
    results: dict[str, Result] = {}
    for name, result, seconds in _run(chosen, threads):
        results[name] = result
        held = sum(check.ok for check in result.checks)
        print(
            f"{name:12} {'pass' if result.ok else 'FAIL'}  {held} of {len(result.checks)} checks, "
            f"{seconds:.1f} s",
            file=stream,
            flush=True,
        )
        for check in result.checks:
            if not check.ok:
                print(
                    f"  {plain(check.quantity)}: {check.measured:.6g} {check.unit}, not "
                    f"{check.exact:.6g} +- {check.tolerance:.3g}",
                    file=stream,
                    flush=True,
                )
    results = {name: results[name] for name in chosen}
    if writes_page:
        path = Path(out or REPORT)
        write_text(path, page(results, version()))
        print(f"report: {path}", file=stream)
    if as_json:
        print(json.dumps({name: facts(result) for name, result in results.items()}, indent=2))
    return all(result.ok for result in results.values())


def facts(result: Result) -> dict[str, Any]:
    """Return the numbers of a result, for JSON."""
    return {
        "pass": result.ok,
        "verdict": plain(result.verdict),
        "checks": [
            {
                "quantity": plain(check.quantity),
                "measured": float(check.measured),
                "exact": float(check.exact),
                "tolerance": float(check.tolerance),
                "rule": check.rule,
                "unit": check.unit,
                "pass": check.ok,
            }
            for check in result.checks
        ],
        "particles": int(result.particles),
        "steps": int(result.steps),
    }


def plain(text: str) -> str:
    """Return `text` without its tags."""
    for tag in ("sub", "sup", "i", "b"):
        text = text.replace(f"<{tag}>", "").replace(f"</{tag}>", "")
    return text


def _chosen(names: Sequence[str]) -> list[str]:
    for name in names:
        if name not in CASES:
            meant = hint(nearest(name, CASES), f"the cases are {', '.join(CASES)}")
            raise RunError(f"there is no validation case {name}{meant}")
    return [name for name in CASES if name in names or not names]


def _run(names: Sequence[str], threads: int) -> Iterator[tuple[str, Result, float]]:
    """Yield the results as they come: the cases are small, so threads run cases and not parts of one."""
    if threads == 1 or len(names) == 1:
        yield from (_timed(name) for name in names)
        return
    yield from processes.results(_timed, names, min(threads, len(names)))


def _timed(name: str) -> tuple[str, Result, float]:
    begun = perf_counter()
    result = CASES[name].run()
    return name, result, perf_counter() - begun
