"""How long a step may be after steps that have failed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from neve.sph.constants import MOST_PRESSURE, MOST_SHEAR
from neve.sph.step import Attempt

GROWTH = 1.25
"""How much longer than the one before a step may be, after one that failed [1]."""
ROOM = 0.8
"""Share of a step that failed, and of the iterations of a solve, that a longer step may take [1]."""
MOST_PATIENCE = 64
"""Steps of one length between two attempts at a longer one, at most."""


class Pace:
    """Bound the next step by what has failed.

    After a step that failed half of it is tried, and steps may then grow up to ROOM of it. A longer one is
    tried only now and then: after twice as many steps as before the last one, if that failed. No step grows
    if a solve had no room: the iterations for pressure grow with dt squared, those for shear with dt.

    longest: of the next step [s]; strain_rate: largest |grad v| of the last [1/s].
    """

    def __init__(self, saved: NDArray[np.float64] | None = None) -> None:
        """Begin, or go on from what `save` returned."""
        values = (0.0, math.inf, math.inf, 1.0, 0.0) if saved is None else map(float, saved)
        self.strain_rate, self.longest, self._failed, self._patience, self._left = values

    def save(self) -> NDArray[np.float64]:
        """Return all that `Pace` goes on from."""
        return np.array([self.strain_rate, self.longest, self._failed, self._patience, self._left])

    def failed(self, dt: float) -> None:
        """Take note of a step of dt [s] that failed; half of it is tried next."""
        self.longest, self._failed = 0.5 * dt, dt
        self._patience = min(2.0 * self._patience, MOST_PATIENCE)
        self._left = self._patience

    def succeeded(self, done: Attempt, bound: bool) -> None:
        """Take note of a step; `bound`: by `longest`."""
        if not bound or math.isinf(self.longest):
            return
        if self.longest >= self._failed:
            self._failed, self._patience = math.inf, 1.0
        grown = GROWTH * self.longest
        if grown > ROOM * self._failed and self._left > 0:
            self._left -= 1
            return
        assert done.shear is not None
        of_pressure = GROWTH**2 * done.pressure.iterations / MOST_PRESSURE
        of_shear = GROWTH * done.shear.iterations / MOST_SHEAR
        if max(of_pressure, of_shear) <= ROOM:
            self.longest = grown
