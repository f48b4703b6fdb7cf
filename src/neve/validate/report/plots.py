"""Draw plots as SVG, for a page that holds them inline; the same curves give the same bytes."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from neve.io.errors import RunError
from neve.validate.result import Curve, Plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK, PAPER, GRID = "#1d2733", "#ffffff", "#e3e8ee"
COLOURS = ("#1769aa", "#d0661c", "#2b8a5f", "#8150a8", "#b8304a", "#5d6b7a", "#a07a00")
MOST_TICKS = 8
"""A logarithmic axis has a tick at each point of a plot, if there are no more than these."""
STYLE: Any = {
    "svg.hashsalt": "neve",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 10.5,
    "axes.edgecolor": "#9aa6b2",
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "figure.facecolor": PAPER,
}


def require_matplotlib() -> None:
    """Raise RunError, in one sentence, if there is nothing to draw plots with."""
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise RunError(
            "the plots of the report need a package: pip install matplotlib, or ask for --json alone"
        ) from None


def svg(plot: Plot) -> str:
    """Return `plot` as an <svg> element."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        figure = draw(plot)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    return re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL).strip()


def draw(plot: Plot) -> Any:
    """Return the figure of `plot`, as matplotlib has it."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    axes = figure.subplots()
    measured = 0
    for curve in plot.curves:
        measured += _draw_curve(axes, curve, COLOURS[measured % len(COLOURS)])
    axes.set_title(plot.title)
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel(plot.y_label)
    axes.set_xscale(plot.x_scale)
    axes.set_yscale(plot.y_scale)
    if plot.x_scale == "log":
        axes.xaxis.set_minor_formatter("")
        axes.xaxis.set_major_formatter("{x:g}")
        ticks = sorted({float(x) for curve in plot.curves for x in curve.x})
        if len(ticks) <= MOST_TICKS:
            axes.set_xticks(ticks)
    if plot.equal:
        axes.set_aspect("equal", adjustable="datalim")
    if any(curve.label for curve in plot.curves):
        figure.legend(loc="outside lower center", ncols=4, markerscale=1.4)
    return figure


def _draw_curve(axes: Axes, curve: Curve, colour: str) -> int:
    """Draw a curve and return whether it took the colour."""
    if curve.kind == "exact":
        if curve.low is not None and curve.high is not None:
            axes.fill_between(curve.x, curve.low, curve.high, color="#7d8fa3", alpha=0.28, linewidth=0)
        axes.plot(curve.x, curve.y, color=INK, linewidth=1.3, label=curve.label)
        return 0
    if curve.kind == "other":
        axes.plot(curve.x, curve.y, color="#7d8fa3", linewidth=1.3, linestyle="--", label=curve.label)
        return 0
    few = np.size(curve.x) <= 60
    style: dict[str, Any] = {"linewidth": 1.5}
    if curve.kind == "dots":
        style = {"marker": ".", "markersize": 2.0, "linestyle": "none"}
    elif few:
        style = {"marker": "o", "markersize": 4.0, "linestyle": "-" if curve.kind == "joined" else "none"}
    axes.plot(curve.x, curve.y, color=colour, label=curve.label, **style)
    return 1
