"""Write the boots and legs of the preset `walk`, its colliders from the mark on: `python tools/walk.py`.

Boots go where their keyframes say, whatever the snow does. A step rolls as a stiff sole does: about the
edge of the heel while the boot comes down, about the edge of the toe while it leaves; neither edge slides.
The shin turns with the boot's shaft and leans a little further. x is forward, z up [m]; angles are in
degrees, about y.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

PRESET = Path(__file__).parents[1] / "src/neve" / "scene" / "presets" / "walk.toml"
MARK = "# Below: written by `python tools/walk.py`.\n"

HEEL, TOE, ANKLE = (-0.14, 0.0), (0.135, 0.0), (-0.078, 0.25)
"""Of the boot `neve:boot` (x, z): the edges that it rolls about, and where the shin begins."""
SURFACE = 0.11
"""Height of the snow [m]."""
SINK = 0.065
"""How deep a boot goes in [m]."""
STRIDE, ASIDE = 0.9, 0.075
"""From one print of a boot to its next, and of a boot from the middle line [m]."""
PERIOD, LANDING = 1.1, 0.1
"""Time of a stride, and when the first print begins [s]."""
DURATION = 2.6
"""End of the preset [s]: keyframes beyond the next one are left out."""
SHIN, RADIUS = 0.8, 0.048
"""Length and radius of a shin [m]; its upper end is above the picture."""
FIRST = -0.7
"""Where the first print is [m]."""

Key = tuple[float, tuple[float, float], float, float]
"""Time [s], place of the boot's origin (x, z) [m], pitch, and how much further the shin leans."""


def turned(point: tuple[float, float], pitch: float) -> tuple[float, float]:
    """Return a point (x, z) turned about y: toe down for positive pitch."""
    c, s = math.cos(math.radians(pitch)), math.sin(math.radians(pitch))
    return c * point[0] + s * point[1], c * point[1] - s * point[0]


def rolled(edge: tuple[float, float], place: tuple[float, float], pitch: float) -> tuple[float, float]:
    """Return where the boot's origin is when its `edge` lies at `place`."""
    dx, dz = turned(edge, pitch)
    return place[0] - dx, place[1] - dz


def step(x: float, t: float, sink: float) -> Iterator[Key]:
    """Return the keyframes of one step that lands at x with the heel at time t and sinks in by `sink`."""
    for share, height, pitch, lean in [  # the heel comes down
        (-0.077, 0.06, -24.0, 2.0),
        (0.0, 0.005, -20.0, 2.0),
        (0.046, -0.6 * sink, -15.0, 2.0),
        (0.085, -0.95 * sink, -9.0, 2.0),
        (0.115, -sink, -3.0, 1.0),
        (0.138, -sink, 0.0, 0.0),
    ]:
        place = (x + HEEL[0], SURFACE + height)
        yield t + share * PERIOD, rolled(HEEL, place, pitch), pitch, lean
    for share, height, on, pitch, lean in [  # the sole lifts off, the toe last
        (0.4, 0.0, 0.0, 0.0, 8.0),
        (0.46, 0.0, 0.0, 9.0, 8.0),
        (0.523, 0.0, 0.0, 22.0, 6.0),
        (0.585, 0.003, 0.0, 38.0, 4.0),
        (0.646, 0.07, 0.05, 50.0, 2.0),
    ]:
        place = (x + TOE[0] + on, SURFACE - sink + height)
        yield t + share * PERIOD, rolled(TOE, place, pitch), pitch, lean
    for share, along, height, pitch in [  # it swings past the other
        (0.74, 0.275, 0.2, 40.0),
        (0.79, 0.5, 0.175, 18.0),
        (0.845, 0.725, 0.13, -4.0),
    ]:
        yield t + share * PERIOD, (x + along * STRIDE, SURFACE + height), pitch, 0.0


def walk(x: float, t: float, sinks: list[float]) -> list[Key]:
    """Return the keyframes of a boot that lands at x at time t first, a step for each depth of `sinks`."""
    keys = [key for i, sink in enumerate(sinks) for key in step(x + i * STRIDE, t + i * PERIOD, sink)]
    before = max((i for i, key in enumerate(keys) if key[0] <= 0.0), default=0)
    after = next(i for i, key in enumerate(keys) if key[0] >= DURATION)
    return [(max(key[0], 0.0), *key[1:]) for key in keys[before : after + 1]]


def collider(name: str, lines: str, motion: list[tuple[float, tuple[float, float], float]], y: float) -> str:
    """Return the table of one collider with its keyframes."""
    keys = "".join(
        f"  {{ t = {t:.3f}, position = [{x:.4f}, {y}, {z:.4f}], rotation = [0.0, {pitch}, 0.0] }},\n"
        for t, (x, z), pitch in motion
    )
    return f"\n[[colliders]] # {name}\n{lines}keyframes = [\n{keys}]\n"


def leg(name: str, keys: list[Key], y: float) -> str:
    """Return the tables of a boot and its shin."""
    shins = []
    for t, (x, z), pitch, lean in keys:
        foot, up = turned(ANKLE, pitch), turned((0.0, 0.5 * SHIN - 0.01), pitch + lean)
        shins.append((t, (x + foot[0] + up[0], z + foot[1] + up[1]), pitch + lean))
    boot = 'shape = "mesh"\nfile = "neve:boot"\nmu_c = 0.1\ncolor = [0.23, 0.11, 0.04]\n'
    shin = f'shape = "cylinder"\nradius = {RADIUS}\nheight = {SHIN}\ncolor = [0.05, 0.07, 0.12]\n'
    return collider(f"the {name} boot", boot, [key[:3] for key in keys], y) + collider(
        f"the {name} shin", shin, shins, y
    )


def colliders() -> str:
    """Return the part of the preset that is written: four prints, right and left in turn. The steps before
    and after them are beyond the snow and the picture."""
    right = walk(FIRST, LANDING, [SINK, SINK, 0.0])
    left = walk(FIRST - 0.5 * STRIDE, LANDING - 0.5 * PERIOD, [0.0, SINK, SINK, 0.0])
    return leg("right", right, -ASIDE) + leg("left", left, ASIDE)


def main() -> None:
    """Write the preset anew from its mark on."""
    text = PRESET.read_text(encoding="utf-8")
    PRESET.write_text(text[: text.index(MARK)] + MARK + colliders(), encoding="utf-8")


if __name__ == "__main__":
    main()
