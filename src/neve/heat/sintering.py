"""How snow at rest grows stronger: the law of core/heat/sintering.hpp, for layers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve import _core

ICE = _core.ice_density
"""Density of ice [kg/m3]."""

Array = NDArray[np.float64]


def grown(growth: Array, density: Array, celsius: Array, dt: float) -> Array:
    """Return the growth of strength [1] after `dt` [s] at `celsius` [deg C] of what was `growth` before.

    growth = (t / 1 s)^0.21, time counted by exp(-Q / R (1 / T - 1 / 268.15 K)), at most the strength of ice
    over that of snow of this density [kg/m3], (917 / density)^2.44. All (n, k).
    """
    a, rho, t = (np.ascontiguousarray(values, np.float64) for values in (growth, density, celsius))
    return _core.heat.grown(a, rho, t, dt)
