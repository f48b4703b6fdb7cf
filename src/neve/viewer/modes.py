"""What the snow's colours can show, with its unit and its legend."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]
Columns = Mapping[str, Callable[[], Any]]
"""Columns of the particles by name, made when they are asked for."""


@dataclass(frozen=True)
class Mode:
    """Describe a colour mode.

    needs: columns without which it cannot be shown. limits: of the legend; None: found from the values.
    palette: of the page. classes: the values are names, not amounts.
    """

    label: str
    unit: str
    needs: tuple[str, ...]
    limits: tuple[float, float] | None = None
    palette: str = "ice"
    classes: bool = False


MODES: Mapping[str, Mode] = {
    "snow": Mode("snow", "", (), (0.0, 1.0)),
    "speed": Mode("speed", "m/s", ("v",)),
    "J_P": Mode("compaction J_P", "1", ("J_P",), (0.7, 1.3), "swing"),
    "density": Mode("density", "kg/m3", ("density",), (0.0, 1000.0)),
    "stress": Mode("von Mises stress", "Pa", ("tau", "F_E"), None, "fire"),
    "material": Mode("material", "", ("material",), (0.0, 65535.0), "names", True),
    "fragment": Mode("fragment", "", ("x", "J_P"), (0.0, 65535.0), "names", True),
}
"""Name -> mode. "snow" is the lit look without figures. No solver lets snow sleep, so none shows that."""

MOST_FRAGMENTS = 400_000
"""Particles above which pieces are not looked for: it would take longer than a moment lasts."""


def available(columns: set[str]) -> list[str]:
    """Return the modes that can be shown from `columns`."""
    return [name for name, mode in MODES.items() if set(mode.needs) <= columns]


def measure(mode: str, columns: Columns, rho0: Array, spacing: float) -> Array:
    """Return what `mode` shows of each particle, (n,), rows in the order of the columns.

    rho0: density of each row of the material table [kg/m3]. spacing: of particles in snow at rest [m].
    """
    if mode == "speed":
        v = np.asarray(columns["v"](), np.float32)
        return np.asarray(np.sqrt(np.einsum("ni,ni->n", v, v)), np.float32)
    if mode == "J_P":
        return np.asarray(columns["J_P"](), np.float32)
    if mode == "density":
        return np.asarray(columns["density"](), np.float32)
    if mode == "material":
        return np.asarray(columns["material"](), np.float32)
    if mode == "stress":
        return _von_mises(columns)
    if mode == "fragment":
        return _fragments(columns, spacing)
    return np.zeros(len(columns["J_P"]()), np.float32)


def _von_mises(columns: Columns) -> Array:
    """Return sqrt(3/2 s:s) / J_E of the Kirchhoff stress's deviator s: of the Cauchy stress per elastic
    volume [Pa].
    """
    tau, F = np.asarray(columns["tau"](), np.float32), np.asarray(columns["F_E"](), np.float32)
    if tau.ndim == 2:  # xx, xy, xz, yy, yz, zz
        xx, xy, xz, yy, yz, zz = tau.T
    else:
        xx, xy, xz, yy, yz, zz = (tau[:, i, j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    square = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + xz**2 + yz**2)
    J_E = np.abs(_determinant(F))
    return np.asarray(np.sqrt(square) / np.maximum(J_E, 1e-3), np.float32)


def _determinant(F: NDArray[Any]) -> NDArray[Any]:
    """Return det F of each F (n, 3, 3) [1], faster than `np.linalg.det`, which factors one at a time."""
    a, b, c = F[:, :, 0], F[:, :, 1], F[:, :, 2]
    return np.asarray(np.einsum("ni,ni->n", a, np.cross(b, c)))


def _fragments(columns: Columns, spacing: float) -> Array:
    """Return a number for each piece that keeps while its first particle stays in it; 0 is powder."""
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


class Scale:
    """Choose the ends of a legend: round numbers that hold nearly all values, and that do not flicker."""

    def __init__(self) -> None:
        self._most: dict[str, float] = {}

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
