"""What the enthalpy of particles means: temperature and phase."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.sampling import Samples
from neve.scene.schema.scene import Scene

LATENT, C_ICE, C_WATER = _core.heat.latent, _core.heat.c_ice, _core.heat.c_water
"""Heat of fusion [J/kg], specific heats of ice and of water [J/(kg K)]: core/heat/enthalpy.hpp."""

Array = NDArray[np.float64]


def enthalpy_of(mass: NDArray[Any], celsius: NDArray[Any] | float, water: NDArray[Any] | float) -> Array:
    """Return the enthalpy [J] of masses [kg] of snow at `celsius` [deg C], `water` of which is liquid [1]."""
    return np.asarray(
        np.asarray(mass, dtype=np.float64) * (C_ICE * np.minimum(celsius, 0.0) + LATENT * water)
    )


def enthalpy_at(scene: Scene, mass: NDArray[Any], samples: Samples | None = None) -> Array:
    """Return the enthalpy (n,) [J] of snow of `mass` (n,) [kg] at birth: zero is ice at the melting point.

    samples: of the snow, with a temperature and water of their own where they have some
    """
    own = samples.temperature if samples is not None else None
    celsius = own if own is not None else scene.heat.snow_temperature if scene.heat else 0.0
    water = samples.liquid if samples is not None and samples.liquid is not None else 0.0
    return enthalpy_of(mass, celsius, water)


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


def columns(state: Callable[[], tuple[NDArray[Any], NDArray[Any]]]) -> dict[str, Callable[[], Array]]:
    """Return what film and viewer may draw: the temperature [deg C], and the phase [1], 0 snow and 1 water.

    state: returns enthalpy [J] and mass [kg] of the particles, (n,) each
    """
    return {"temperature": lambda: temperature(*state()), "phase": lambda: liquid(*state())}
