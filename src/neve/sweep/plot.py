"""Plots of the table of a sweep."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from neve.io.atomic import replacing
from neve.io.errors import RunError
from neve.spelling import hint, nearest
from neve.sweep.table import CSV, DONE, OWN, read

MOST = 6
"""Outputs that are drawn unless some are named."""
SUFFIXES = (".png", ".svg", ".pdf")


def plot(
    path: Path, out: Path | None = None, x: str | None = None, y: Sequence[str] = (), by: str | None = None
) -> Path:
    """Draw outputs of the sweep at `path` over an input, a panel for each; return the file.

    x: input along the axis, by default the first that varies; y: outputs, by default the first ones that vary
    by: input with a line for each of its values, by default the second that varies, if it has few values

    Errors: RunError.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise RunError("plots need a package: pip install matplotlib.") from None
    rows = [row for row in read(path) if row["status"] == DONE]
    target = out or (path if path.is_dir() else path.parent) / "sweep.png"
    if target.suffix not in SUFFIXES:
        raise RunError(f"--out {target}: a plot ends in {', '.join(SUFFIXES)}.")
    if not rows:
        raise RunError(f"{path} holds no run that is done, so there is nothing to plot.")
    names = [*rows[0]]
    inputs = names[1 : names.index(OWN[1])]
    outputs = [name for name in names[names.index(OWN[-1]) + 1 :] if _is_number(rows, name)]
    varies = [name for name in inputs if len({row[name] for row in rows}) > 1] or inputs
    x = _known("--x", x, inputs) or varies[0]
    lines = [name for name in varies if name != x and len({row[name] for row in rows}) <= MOST]
    by = _known("--by", by, inputs) or (lines[0] if lines else None)
    changing = [name for name in outputs if len({row[name] for row in rows}) > 1]
    chosen = [name for word in y if (name := _known("--y", word, outputs))] or (changing or outputs)[:MOST]
    if not chosen:
        raise RunError(f"{path} holds no outputs that are numbers, so there is nothing to plot.")
    columns = min(3, len(chosen))
    lanes = math.ceil(len(chosen) / columns)
    figure = Figure(figsize=(1.0 + 4.2 * columns, 0.4 + 3.2 * lanes), layout="constrained")
    panels = np.ravel(figure.subplots(lanes, columns))
    for axes, name in zip(panels, chosen, strict=False):
        _draw(axes, rows, x, name, by)
    for axes in panels[len(chosen) :]:
        axes.set_visible(False)
    with replacing(target) as file:
        figure.savefig(file, format=target.suffix[1:], dpi=120)
    return target


def _draw(axes: Any, rows: Sequence[dict[str, str]], x: str, y: str, by: str | None) -> None:
    """Draw an output over an input: a line for each value of `by`."""
    are_numbers = _is_number(rows, x)
    for value in dict.fromkeys(row[by] if by else "" for row in rows):
        part = [row for row in rows if row[x] and row[y] and (not by or row[by] == value)]
        along = [float(row[x]) if are_numbers else row[x] for row in part]
        pairs = sorted(zip(along, (float(row[y]) for row in part), strict=True), key=lambda pair: pair[0])
        axes.plot(*zip(*pairs, strict=True), "o-", label=_said(by, value)) if pairs else None
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(alpha=0.3)
    if are_numbers and _is_wide([float(row[x]) for row in rows if row[x]]):
        axes.set_xscale("log")
    if by:
        axes.legend(fontsize="small")


def _said(by: str | None, value: str) -> str | None:
    return by and (f"{by} = {value}" if value else f"without {by}")


def _is_wide(values: Sequence[float]) -> bool:
    """Tell whether values lie over more than one and a half decades."""
    return min(values) > 0 and max(values) > 30 * min(values)


def _is_number(rows: Sequence[dict[str, str]], name: str) -> bool:
    try:
        return all(math.isfinite(float(row[name])) for row in rows if row[name]) and any(
            row[name] for row in rows
        )
    except ValueError:
        return False


def _known(option: str, word: str | None, names: Sequence[str]) -> str | None:
    """Return `word` if it is one of `names`. Errors: RunError."""
    if word is not None and word not in names:
        meant = hint(nearest(word, names), f"{CSV} has {', '.join(names)}")
        raise RunError(f"{option} {word}: there is no such column{meant}.")
    return word
