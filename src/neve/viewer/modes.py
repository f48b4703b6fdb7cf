"""What the snow's colours can show: each mode with its measure, its unit and its legend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.build import material_table
from neve.reproducible import determinant
from neve.scene.schema.scene import Scene
from neve.viewer.protocol.messages import LegendName
from neve.viewer.protocol.messages import Mode as ModeMessage

Array = NDArray[np.float32]
Columns = Mapping[str, Callable[[], Any]]
"""Columns of the particles by name, each made when it is asked for."""

Palette = tuple[tuple[int, int, int], ...]
"""Colours from the least to the greatest value, red, green and blue from 0 to 255."""

ICE: Palette = ((34, 60, 122), (36, 104, 160), (58, 160, 190), (160, 222, 205), (250, 250, 210))
FIRE: Palette = ((58, 34, 104), (122, 34, 104), (190, 54, 68), (246, 132, 42), (252, 236, 150))
THAW: Palette = ((244, 248, 252), (196, 222, 240), (120, 180, 224), (52, 120, 196), (16, 60, 140))
DIVERGING: Palette = ((26, 62, 140), (110, 160, 214), (238, 238, 238), (232, 150, 96), (150, 34, 28))

WETNESS = "phase"
"""The mode whose values say in the mode "snow" how wet each particle is."""

MOST_FRAGMENTS = 400_000
"""Particles above which fragments are not looked for: it would take longer than a snapshot lasts."""


@dataclass(frozen=True)
class Mode:
    """Describe a colour mode.

    measure: return what it shows of each particle, (n,), rows in the order of the columns, from the columns
    and the spacing [m] of particles in snow at rest; None: the lit look without figures. needs: columns
    without which it cannot be shown. limits: of the legend; None: found from the values. names: of a mode
    whose values are names, not amounts: the lines of its legend, given the scene. slow: measuring takes
    longer than a time step, so a live run measures it about once a second.
    """

    label: str
    unit: str
    needs: tuple[str, ...]
    measure: Callable[[Columns, float], Array] | None
    limits: tuple[float, float] | None = None
    palette: Palette = ICE
    names: Callable[[Scene], list[LegendName]] | None = None
    slow: bool = False


def available(columns: set[str]) -> list[str]:
    """Return the modes that can be shown from `columns`."""
    return [name for name, mode in MODES.items() if set(mode.needs) <= columns]


def measure(mode: str, columns: Columns, spacing: float) -> Array:
    """Return what `mode` shows of each particle, (n,), rows in the order of the columns.

    spacing: of particles in snow at rest [m].
    """
    function = MODES[mode].measure
    if function is None:
        raise ValueError(f"the colour mode {mode} measures nothing")
    return function(columns, spacing)


def described(names: list[str], scene: Scene) -> list[ModeMessage]:
    """Return the message of each of the modes `names`."""
    found: list[ModeMessage] = []
    for name in names:
        mode = MODES[name]
        found.append(
            {
                "name": name,
                "label": mode.label,
                "unit": mode.unit,
                "classes": mode.names is not None,
                "stops": list(mode.palette),
                "names": mode.names(scene) if mode.names else [],
            }
        )
    return found


def _column(name: str) -> Callable[[Columns, float], Array]:
    """Return a measure that shows a column as it stands."""
    return lambda columns, spacing: np.asarray(columns[name](), np.float32)


def _speed(columns: Columns, spacing: float) -> Array:
    """Return |v| [m/s]."""
    v = np.asarray(columns["v"](), np.float32)
    return np.asarray(np.sqrt(np.einsum("ni,ni->n", v, v)), np.float32)


def _material_names(scene: Scene) -> list[LegendName]:
    """Return what the legend calls each row of the material table: its kind, and whose snow it is."""
    rows = material_table(scene)
    names: list[LegendName] = []
    for i, snow in enumerate(rows):
        whose = [str(k) for k, source in enumerate(scene.bearers) if scene.snow_of(source) == snow]
        text = snow.kind if len(rows) == 1 else f"{snow.kind}, of sources {', '.join(whose[:6])}"
        names.append({"value": i, "text": text})
    return names


def _sleep_names(scene: Scene) -> list[LegendName]:
    """Return what the legend calls snow that a step moves, and snow that it leaves out."""
    return [{"value": 0, "text": "moves"}, {"value": 1, "text": "sleeps"}]


def _fragment_names(scene: Scene) -> list[LegendName]:
    """Return two lines: fragments are too many to name each."""
    return [{"value": 0, "text": "powder"}, {"value": None, "text": "any other colour: a fragment"}]


def _von_mises(columns: Columns, spacing: float) -> Array:
    """Return sqrt(3/2 s:s) / J_E of the Kirchhoff stress's deviator s: of the Cauchy stress per elastic
    volume [Pa].
    """
    tau, F = np.asarray(columns["tau"](), np.float32), np.asarray(columns["F_E"](), np.float32)
    xx, yy, zz, xy, xz, yz = tau.T
    square = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + xz**2 + yz**2)
    J_E = np.abs(determinant(F))
    return np.asarray(np.sqrt(square) / np.maximum(J_E, 1e-3), np.float32)


def _fragments(columns: Columns, spacing: float) -> Array:
    """Return a number for each fragment, kept while its first particle stays in it; 0 is powder."""
    from neve.fragments import find

    x, J_P = np.asarray(columns["x"]()), np.asarray(columns["J_P"]())
    n = len(J_P)
    if n > MOST_FRAGMENTS:
        return np.zeros(n, np.float32)
    ones = np.ones(n)
    label = find(x, np.zeros((n, 3)), J_P, ones, ones, spacing).label
    first = np.full(int(label.max(initial=0)) + 1, n, np.int64)
    np.minimum.at(first, label, np.arange(n))
    name = 1 + first * 2654435761 % 65521
    name[0] = 0
    return np.asarray(name[label], np.float32)


MODES: Mapping[str, Mode] = {
    "snow": Mode("snow", "", (), None, (0.0, 1.0)),
    "speed": Mode("speed", "m/s", ("v",), _speed),
    "J_P": Mode("compaction J_P", "1", ("J_P",), _column("J_P"), (0.7, 1.3), DIVERGING),
    "density": Mode("density", "kg/m3", ("density",), _column("density"), (0.0, 1000.0)),
    "stress": Mode("von Mises stress", "Pa", ("tau", "F_E"), _von_mises, None, FIRE),
    "temperature": Mode(
        "temperature", "deg C", ("temperature",), _column("temperature"), (-15.0, 5.0), DIVERGING
    ),
    "phase": Mode("liquid share", "1", ("phase",), _column("phase"), (0.0, 1.0), THAW),
    "asleep": Mode("asleep", "", ("asleep",), _column("asleep"), (0.0, 65535.0), names=_sleep_names),
    "material": Mode(
        "material", "", ("material",), _column("material"), (0.0, 65535.0), names=_material_names
    ),
    "fragment": Mode(
        "fragment", "", ("x", "J_P"), _fragments, (0.0, 65535.0), names=_fragment_names, slow=True
    ),
}
"""Name -> mode: an entry here is all that a new mode needs. "snow" is the lit look without figures."""


@dataclass(frozen=True)
class Colors:
    """Hold what a page colours the snow by: a mode, the ends of its legend if chosen, and their spacing."""

    mode: str = "snow"
    limits: tuple[float, float] | None = None
    log: bool = False


DECADES = 1e-4
"""Least value of a legend that is spaced by powers, as a share of the greatest, if no other is chosen."""


class Scale:
    """Choose the ends of a legend: round numbers that span nearly all values and do not flicker."""

    def __init__(self) -> None:
        self._most: dict[str, float] = {}

    def of(self, colors: Colors, values: Array) -> tuple[tuple[float, float], bool]:
        """Return the values that get the first and the last colour, and whether powers are between them.

        Only positive values have powers; names have none.
        """
        low, high = colors.limits or self.limits(colors.mode, values)
        if not colors.log or high <= 0.0 or MODES[colors.mode].names is not None:
            return (low, high), False
        return (low if low > 0.0 else DECADES * high, high), True

    def limits(self, mode: str, values: Array) -> tuple[float, float]:
        """Return the values that get the first and the last colour."""
        fixed = MODES[mode].limits
        if fixed is not None:
            return fixed
        some = values[:: max(1, len(values) // 20_000)]
        some = some[np.isfinite(some)]
        high = float(np.quantile(some, 0.98)) if len(some) else 1.0
        held = self._most.get(mode, 0.0)
        if not held or high > held or high < 0.35 * held:
            self._most[mode] = held = rounded(max(1.05 * high, 1e-3))
        return 0.0, held


def rounded(value: float) -> float:
    """Return the next of 1, 1.5, 2, 3, 5, 7 times a power of ten at or above `value` > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = [step for step in (1.0, 1.5, 2.0, 3.0, 5.0, 7.0) if step * power >= value * (1 - 1e-12)]
    return float((steps[0] if steps else 10.0) * power)
