"""The state of snow that lies: layers with a density, temperature, strength and age of their own."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from neve import _core

Array = NDArray[np.float64]

MELTING = 0.0
"""Temperature above which there is no snow [deg C]."""
OF_STIFFNESS, OF_STRENGTH = 4.4, _core.heat.strength_power
"""Powers of density with which Young's modulus (Bergfeld et al. 2023) and tensile strength (Sigrist 2006)
grow, as public code quotes them [1]."""


@dataclass(frozen=True, eq=False)
class Layers:
    """Hold the layers over n places, k over each from the surface up; those of no thickness are empty.

    Attributes:
        thickness: upright [m], (n, k)
        density: [kg/m3], (n, k)
        born: density as it fell, which the constants of the snow are those of [kg/m3], (n, k)
        temperature: [deg C], at most 0, (n, k)
        liquid: share of the mass that is water [1], (n, k)
        growth: of strength by sintering [1], at least 1, (n, k)
        age: since it fell [s], (n, k)
    """

    thickness: Array
    density: Array
    born: Array
    temperature: Array
    liquid: Array
    growth: Array
    age: Array

    @classmethod
    def fresh(cls, thickness: Array, density: float, temperature: float, age: Array) -> Layers:
        """Return layers of new snow of one density [kg/m3] and temperature [deg C]; age (k,) [s].

        Their arrays cannot be written, but for the thickness.
        """

        def all_of(value: float) -> Array:  # which takes no memory
            return np.broadcast_to(np.float64(value), thickness.shape)

        return cls(
            thickness=thickness,
            density=all_of(density),
            born=all_of(density),
            temperature=all_of(min(temperature, MELTING)),
            liquid=all_of(0.0),
            growth=all_of(1.0),
            age=np.broadcast_to(age, thickness.shape),
        )

    def but(self, **changed: Array) -> Layers:
        """Return these layers with other arrays, by name."""
        return replace(self, **changed)

    def arrays(self) -> dict[str, Array]:
        """Return all arrays by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def depth(self) -> Array:
        """Of the snow on each place [m], (n,)."""
        return np.asarray(self.thickness.sum(axis=1))

    @property
    def mass(self) -> Array:
        """Of each layer on an area [kg/m2], (n, k)."""
        return self.thickness * self.density

    def at(self, place: NDArray[np.int64], height: Array) -> NDArray[np.int64]:
        """Return which layer lies at these heights [m] above the surface of places, rows of these: (m,) each.

        Above the snow it is the highest layer that is not empty.
        """
        tops = np.cumsum(self.thickness, axis=1)
        k = np.sum(tops[place] <= height[:, None], axis=1)
        highest = tops.shape[1] - 1 - np.argmax(self.thickness[:, ::-1] > 0.0, axis=1)
        return np.asarray(np.minimum(k, highest[place]))

    def stiffness(self) -> Array:
        """Return the factor on Young's modulus that follows from the density [1], (n, k)."""
        return np.asarray((self.density / self.born) ** OF_STIFFNESS)

    def strength(self) -> Array:
        """Return the factor on the thresholds that follows from the density alone [1], (n, k)."""
        return np.asarray((self.density / self.born) ** OF_STRENGTH)


def restacked(thickness: Array, depth: Array) -> Array:
    """Return layers (n, k) [m] of new depths (n,) [m]: taken from the top, or more on it."""
    out = thickness.copy()
    gone = out.sum(axis=1) - depth
    for k in reversed(range(out.shape[1])):
        taken = np.clip(gone, 0.0, out[:, k])
        out[:, k] -= taken
        gone -= taken
    out[:, -1] += np.maximum(-gone, 0.0)
    return out
