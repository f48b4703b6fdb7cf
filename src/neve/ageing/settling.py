"""Snow settles under its own weight: a viscous fluid whose viscosity grows with density and cold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.ageing.warming import WATER
from neve.heat.sintering import ICE
from neve.snowfall.layers import Layers

Array = NDArray[np.float64]

ETA0, C_ETA, A_ETA, B_ETA = 7.62237e6, 250.0, 0.1, 0.023
"""Of the viscosity eta0 (rho / c) exp(a (T_m - T) + b rho): [Pa s], [kg/m3], [1/K], [m3/kg].

Vionnet et al. 2012 (the snow model Crocus), as public code quotes them.
"""
WET = 60.0
"""Of the factor 1 / (1 + 60 theta) on the viscosity of wet snow, theta the share of its volume that is water
[1] (the same, from memory)."""


def load_on(layers: Layers, gravity: float) -> Array:
    """Return the pressure in the middle of each layer [Pa], (n, k): the weight above it and half its own."""
    mass = layers.mass
    above = np.cumsum(mass[:, ::-1], axis=1)[:, ::-1] - mass
    return gravity * (above + 0.5 * mass)


def viscosity(density: Array, celsius: Array, theta: Array) -> Array:
    """Return the viscosity [Pa s] of snow of a density [kg/m3], temperature and volume share of water [1]."""
    dry = ETA0 * (density / C_ETA) * np.exp(A_ETA * -np.minimum(celsius, 0.0) + B_ETA * density)
    return np.asarray(dry / (1.0 + WET * theta))


def settled(layers: Layers, dt: float, gravity: float) -> Layers:
    """Return the layers after `dt` [s] of settling: d rho / dt = rho sigma / eta(rho, T).

    The load sigma on a layer does not change, so that with the viscosity above
    rho(t) = rho + ln(1 + b K t exp(-b rho)) / b, K = sigma c exp(-a (T_m - T)) / eta0, exactly for any `dt`
    at one temperature; up to the density of ice. Mass, and water, stay.
    """
    rho = layers.density
    theta = np.minimum(layers.liquid * rho / WATER, 1.0)
    pace = load_on(layers, gravity) * C_ETA / ETA0 * (1.0 + WET * theta)
    pace *= np.exp(A_ETA * np.minimum(layers.temperature, 0.0))
    denser = rho + np.log1p(B_ETA * pace * dt * np.exp(-B_ETA * rho)) / B_ETA
    denser = np.maximum(np.minimum(denser, ICE), rho)
    return layers.but(thickness=layers.thickness * (rho / denser), density=denser)
