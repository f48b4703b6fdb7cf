"""Draw how networks learned: `python tools/learned_loss.py` writes the picture of docs/implicit.md."""

from __future__ import annotations

import math
from pathlib import Path

from neve.learned.shipped import shipped
from neve.learned.targets import TARGETS

PATH = Path("docs") / "images" / "learned_loss.svg"  # from the root of the checkout
WIDTH, HEIGHT, EDGE = 560, 240, 46
COLOURS = ("#1f5f99", "#b5522b")


def curve(losses: list[float], low: float, high: float, colour: str) -> str:
    """Return a line of the losses, whose logarithms reach from low to high."""
    points = " ".join(
        f"{EDGE + (WIDTH - 2 * EDGE) * k / (len(losses) - 1):.1f},"
        f"{HEIGHT - EDGE - (HEIGHT - 2 * EDGE) * (math.log10(loss) - low) / (high - low):.1f}"
        for k, loss in enumerate(losses)
    )
    return f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>'


def picture() -> str:
    """Return the picture."""
    found = {law: shipped(law)["curve"] for law in TARGETS}
    low = math.floor(min(math.log10(min(losses)) for losses in found.values()))
    high = math.ceil(max(math.log10(max(losses)) for losses in found.values()))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for power in range(low, high + 1):
        y = HEIGHT - EDGE - (HEIGHT - 2 * EDGE) * (power - low) / (high - low)
        parts.append(f'<line x1="{EDGE}" x2="{WIDTH - EDGE}" y1="{y:.1f}" y2="{y:.1f}" stroke="#ddd"/>')
        parts.append(f'<text x="{EDGE - 6}" y="{y + 4:.1f}" text-anchor="end">1e{power}</text>')
    for k, (law, losses) in enumerate(found.items()):
        parts.append(curve(losses, low, high, COLOURS[k]))
        parts.append(f'<text x="{WIDTH - EDGE - 150}" y="{EDGE + 18 * k}" fill="{COLOURS[k]}">{law}</text>')
    last = max(len(losses) for losses in found.values()) - 1
    parts.append(f'<text x="{EDGE}" y="{HEIGHT - EDGE + 18}">0</text>')
    parts.append(
        f'<text x="{WIDTH - EDGE}" y="{HEIGHT - EDGE + 18}" text-anchor="end">{last} iterations</text>'
    )
    parts.append(f'<text x="{EDGE}" y="{EDGE - 20}">loss</text>')
    return "\n".join([*parts, "</svg>", ""])


if __name__ == "__main__":
    PATH.write_text(picture(), encoding="utf-8")
    print(f"wrote {PATH}")
