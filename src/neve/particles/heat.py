"""Heat of particles: what the core needs of a scene's heat, and what its columns mean."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.schema.scene import Scene

if TYPE_CHECKING:
    from neve._core import Particles

LATENT, C_ICE, C_WATER = 3.34e5, 2100.0, 4182.0
"""Heat of fusion [J/kg], specific heats of ice and of water [J/(kg K)]: core/particles/enthalpy.hpp."""
INTERVAL = 0.01
"""Time between two passes over the heat, of motion [s]."""

Array = NDArray[np.float64]


def set_heat(scene: Scene, particles: Particles) -> None:
    """Give the core the heat of `scene`, if it has any."""
    heat = scene.heat
    if heat is None:
        return
    conductivity = 0.0 if heat.conductivity == "density" else float(heat.conductivity)
    absorbed = heat.sun * (1.0 - heat.albedo)
    towards = list(scene.light.towards_sun)
    particles.set_heat(
        heat.air_temperature,
        heat.air_exchange,
        absorbed,
        towards,
        conductivity,
        heat.heat_speed,
        heat.sintering,
    )


def enthalpy_at(scene: Scene, mass: NDArray[Any]) -> Array:
    """Return the enthalpy (n,) [J] of snow of `mass` (n,) [kg] at birth: zero is ice at the melting point."""
    celsius = scene.heat.snow_temperature if scene.heat else 0.0
    return np.asarray(mass, dtype=np.float64) * C_ICE * celsius


def temperature(enthalpy: NDArray[Any], mass: NDArray[Any]) -> Array:
    """Return the temperature (n,) [deg C] of `mass` (n,) [kg] with `enthalpy` (n,) [J].

    Below zero solid, up to LATENT per mass a mush at the melting point, water above.
    """
    e, m = (np.asarray(a, dtype=np.float64) for a in (enthalpy, mass))
    return np.asarray(np.minimum(e, 0.0) / (m * C_ICE) + np.maximum(e - m * LATENT, 0.0) / (m * C_WATER))


def liquid(enthalpy: NDArray[Any], mass: NDArray[Any]) -> Array:
    """Return the share of `mass` (n,) [kg] that is water at `enthalpy` (n,) [J]: (n,) [1]."""
    e, m = (np.asarray(a, dtype=np.float64) for a in (enthalpy, mass))
    return np.asarray(np.clip(e / (m * LATENT), 0.0, 1.0))
