"""Fit the two numbers of the game's snow, strain and pressure, to wheels that MPM rolled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from neve.drive.law import GameSnow, bearing_ratio, contact_area, wheel_sinkage
from neve.drive.track import Track

Array = NDArray[np.float64]

STRAINS = (0.2, 0.5, 0.8)
PRESSURES = (1e3, 1e4, 1e5)
"""Where searches begin [1], [Pa]: their minima differ, the least one counts."""
CLOSE = {"ftol": 1e-14, "xtol": 1e-10, "gtol": 1e-14}
"""How close a search comes: at small pressures the two numbers say almost the same, along a long valley."""
DOUBTFUL = 0.5
"""Relative standard error of a number from which on the run does not tell it [1]."""


class Fit(NamedTuple):
    """Hold the fitted snow.

    snow. predicted: sinkage of each track's moments by the law [m]. residual: root mean square of what is
    left [m]. strain_error, pressure_error: standard errors [1, Pa], from the slopes at the minimum; infinite
    where the runs do not tell the number. density_ratio: of the ruts by MPM, and as the law has it, mean [1].
    """

    snow: GameSnow
    predicted: tuple[Array, ...]
    residual: float
    strain_error: float
    pressure_error: float
    density_ratio: tuple[float, float]

    @property
    def untold(self) -> list[str]:
        """Return the numbers that the runs do not tell, by their standard errors."""
        doubts = {
            "strain": self.strain_error / self.snow.strain,
            "pressure": self.pressure_error / self.snow.pressure,
        }
        return [name for name, doubt in doubts.items() if not doubt < DOUBTFUL]


def fitted(tracks: Sequence[Track]) -> Fit:
    """Return the snow of the game whose sinkage is nearest to that of the tracks, by least squares.

    Every moment of every track counts the same. The compaction is measured, not fitted: the mean of the ruts.
    """
    compaction = float(np.mean([track.rut.compaction for track in tracks]))
    measured = np.concatenate([track.sinkage for track in tracks])

    def snow_at(guess: Array) -> GameSnow:
        return GameSnow(float(1.0 / (1.0 + np.exp(-guess[0]))), float(np.exp(guess[1])), compaction)

    def miss(guess: Array) -> Array:
        return np.asarray(np.concatenate(_sinkages(tracks, snow_at(guess))) - measured)

    # Within these bounds exp() is finite and strain stays below 1 by more than rounding.
    bounds = ([-8.0, np.log(1.0)], [8.0, np.log(1e9)])
    starts = [(np.log(s / (1.0 - s)), np.log(p)) for s in STRAINS for p in PRESSURES]
    rough = [least_squares(miss, start, bounds=bounds) for start in starts]
    nearest = min(rough, key=lambda end: float(end.cost))
    best = least_squares(miss, nearest.x, bounds=bounds, **CLOSE)
    snow = snow_at(best.x)
    left = miss(best.x)
    errors = _errors(best.jac, left)
    return Fit(
        snow,
        tuple(_sinkages(tracks, snow)),
        float(np.sqrt(np.mean(left**2))),
        errors[0] * snow.strain * (1.0 - snow.strain),
        errors[1] * snow.pressure,
        _densities(tracks, snow),
    )


def _sinkages(tracks: Sequence[Track], snow: GameSnow) -> list[Array]:
    return [
        wheel_sinkage(track.wheel.radius, track.wheel.width, track.load, track.depth, snow)
        for track in tracks
    ]


def _errors(slopes: Array, left: Array) -> tuple[float, float]:
    """Return standard errors of the two numbers of the search; infinite where slopes do not tell them."""
    normal = np.einsum("ki,kj->ij", slopes, slopes)
    scale = float(np.sum(left**2)) / max(1, len(left) - 2)
    if np.linalg.cond(normal) > 1e12:
        return np.inf, np.inf
    spread = np.sqrt(np.diag(np.linalg.inv(normal)) * scale)
    return float(spread[0]), float(spread[1])


def _densities(tracks: Sequence[Track], snow: GameSnow) -> tuple[float, float]:
    """Return how much denser the ruts are, as measured and by the law under the mean pressure."""
    law = []
    for track in tracks:
        area = contact_area(track.wheel.radius, track.wheel.width, track.sinkage)
        law.append(float(bearing_ratio(snow, track.load / area).mean()))
    return float(np.mean([track.rut.density_ratio for track in tracks])), float(np.mean(law))
