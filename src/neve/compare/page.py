"""The page of a comparison: film, table and curves, as HTML that needs only the film beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from neve.compare.film import FILM, STILL
from neve.compare.measures import UNITS, Curve, Measures
from neve.registry import METHODS

if TYPE_CHECKING:
    from neve.compare.run import Compared
    from neve.scene.schema.scene import Scene

PAGE = "compare.html"
MEANINGS = {
    "particles": "particles", "steps": "steps", "dt": "mean step", "seconds": "time in the steps",
    "seconds_per_million": "time to move a million particles once", "mass": "mass of the snow",
    "kinetic": "kinetic energy", "elastic": "elastic energy",
    "lost": "energy lost to friction, breaking and flow", "momentum": "momentum of the snow",
    "height": "height of its centre of mass", "spread": "root mean square distance from it",
    "fragments": "fragments", "largest": "share of the mass in the largest",
}  # fmt: skip
INKS = ("#1769aa", "#c2571a", "#2f7d4f", "#8a3fa0", "#a6262b", "#5b6770")
STYLE = """
:root { color-scheme: light; --ink: #1d2733; --soft: #5d6b7a; --line: #dde4eb; }
body { font: 16px/1.55 system-ui, sans-serif; color: var(--ink); background: #f4f7fa; margin: 0; }
main { max-width: 72rem; margin: 0 auto; padding: 2rem 1.25rem 4rem; }
video { width: 100%; border-radius: 10px; background: #000; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1.2rem 0; }
th, td { border-bottom: 1px solid var(--line); padding: .35rem .9rem .35rem 0; text-align: right; }
th:first-child, td:first-child { text-align: left; }
.soft { color: var(--soft); } svg { width: 100%; max-width: 46rem; height: auto; display: block; }
"""


def page(scene: Scene, found: Sequence[Compared]) -> str:
    """Return the page of a comparison of `scene`."""
    ran = [part for part in found if part.measures]
    refused = "".join(f"<p>{escape(p.method)}: {escape(p.refused)}</p>" for p in found if p.refused)
    seconds = ran[0].curve.time[-1] if ran[0].curve else 0.0
    methods = "; ".join(f"{part.method}: {METHODS.meanings.get(part.method, '')}" for part in ran)
    title = f"{scene.about or 'A scene'} By {len(ran)} methods"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body><main>\n"
        f"<h1>{escape(title)}</h1>\n"
        f'<p class="soft">The same scene on the same clock, {seconds:g} s. {escape(methods)}.</p>\n'
        f'<video src="{FILM}" poster="{STILL}" controls loop muted></video>\n{refused}'
        f"{_table(ran)}<h2>Kinetic energy</h2>\n{_curves(ran)}</main></body>\n</html>\n"
    )


def _table(ran: Sequence[Compared]) -> str:
    """Return the measures, a column for each method."""
    head = "".join(f"<th>{escape(part.method)}</th>" for part in ran)
    rows = ""
    for name, unit in UNITS.items():
        cells = "".join(f"<td>{_number(part.measures, name)}</td>" for part in ran)
        rows += f'<tr><td>{MEANINGS[name]}</td>{cells}<td class="soft">{unit}</td></tr>\n'
    return f"<table>\n<tr><th>at the end</th>{head}<th></th></tr>\n{rows}</table>\n"


def _number(measures: Measures | None, name: str) -> str:
    value = getattr(measures, name)
    if isinstance(value, int):
        return f"{value:,}"
    return "not known" if math.isnan(value) else f"{value:.4g}"


def _curves(ran: Sequence[Compared]) -> str:
    """Return the kinetic energy over time of each method as a picture."""
    curves = [(part.method, part.curve) for part in ran if part.curve]
    most = max((float(np.nanmax(curve.kinetic, initial=0.0)) for _, curve in curves), default=0.0) or 1.0
    end = max((float(curve.time[-1]) for _, curve in curves), default=0.0) or 1.0
    lines = "".join(
        f'<polyline fill="none" stroke="{INKS[i % len(INKS)]}" stroke-width="2" '
        f'points="{_points(curve, end, most)}"/>'
        f'<text x="70" y="{24 + 18 * i}" fill="{INKS[i % len(INKS)]}" font-size="14">{escape(method)}</text>'
        for i, (method, curve) in enumerate(curves)
    )
    return (
        '<svg viewBox="0 0 640 280" role="img" aria-label="kinetic energy over time">'
        '<path d="M60 10V240H630" fill="none" stroke="#7d8fa3"/>'
        f'<text x="54" y="18" text-anchor="end" font-size="12">{most:.3g} J</text>'
        '<text x="54" y="244" text-anchor="end" font-size="12">0</text>'
        f'<text x="630" y="260" text-anchor="end" font-size="12">{end:g} s</text>{lines}</svg>\n'
    )


def _points(curve: Curve, end: float, most: float) -> str:
    """Return the points of a line in a field of 570 x 230."""
    return " ".join(
        f"{60 + 570 * t / end:.1f},{240 - 230 * max(k, 0.0) / most:.1f}"
        for t, k in zip(curve.time, curve.kinetic, strict=True)
        if math.isfinite(k)
    )
