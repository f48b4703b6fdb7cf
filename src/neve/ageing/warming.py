"""Heat in layers of snow, from air, sun and ground: they melt, and water seeps and freezes again.

Each layer holds an enthalpy e [J/m2], zero for ice at the melting point, as the particles of a run do
(`neve.heat.enthalpy`). What flows between two layers is taken from one as it is given to the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.heat.enthalpy import C_ICE, LATENT, enthalpy_of
from neve.heat.sintering import ICE
from neve.snowfall.layers import Layers

Array = NDArray[np.float64]

WATER = 1000.0
"""Density of water [kg/m3]."""
HOLDS = 0.05
"""Share of the pores that water fills before it seeps on (the snow model Crocus, from memory) [1]."""
ROUNDS = 8
"""In which it is found which layers are at the melting point."""


@dataclass(frozen=True)
class Surroundings:
    """Say what gives heat to the snow now.

    air: temperature [deg C]; exchange: with the air [W/(m2 K)]; sun: absorbed on each place [W/m2], (n,);
    ground: temperature at the foot of the snow [deg C], None for none that conducts
    """

    air: float
    exchange: float
    sun: Array
    ground: float | None = None


def enthalpy(layers: Layers) -> Array:
    """Return the enthalpy of each layer [J/m2], (n, k)."""
    return enthalpy_of(layers.mass, layers.temperature, layers.liquid)


def conductivity(density: Array) -> Array:
    """Return 2.5e-6 rho^2 - 1.23e-4 rho + 0.024 [W/(m K)] (Calonne et al. 2011), at least 0.01."""
    return _core.heat.conductivity(np.ascontiguousarray(density, np.float64))


def packed(layers: Layers) -> Layers:
    """Return the layers with the empty ones of each place on top, the others in their order."""
    order = np.argsort(layers.thickness <= 0.0, axis=1, kind="stable")
    return Layers(**{name: np.take_along_axis(a, order, axis=1) for name, a in layers.arrays().items()})


@dataclass(frozen=True, eq=False)
class Conduction:
    """Hold how heat flows in the layers of n places.

    C: heat capacity of each layer [J/(m2 K)], 0 of an empty one, (n, k); g: conductance between each and the
    next above [W/(m2 K)], (n, k - 1); r: resistance between the middle of the highest and its surface
    [m2 K/W], (n,); foot: conductance to the ground [W/(m2 K)], (n,); top: row of the highest, (n, 1)
    """

    C: Array
    g: Array
    r: Array
    foot: Array
    top: NDArray[np.int64]
    around: Surroundings

    @classmethod
    def of(cls, layers: Layers, around: Surroundings) -> Conduction:
        """Return that of layers which are `packed`."""
        mass = layers.mass
        there = mass > 0.0
        half = np.where(there, 0.5 * layers.thickness / conductivity(layers.density), 0.0)
        joined = there[:, 1:] & there[:, :-1]
        g = np.where(joined, 1.0 / np.where(joined, half[:, 1:] + half[:, :-1], 1.0), 0.0)
        top = np.maximum(there.sum(axis=1) - 1, 0)[:, None]
        foot = np.zeros(len(mass))
        if around.ground is not None:
            foot = np.where(there[:, 0], 1.0 / np.where(there[:, 0], half[:, 0], 1.0), 0.0)
        return cls(mass * C_ICE, g, np.take_along_axis(half, top, axis=1)[:, 0], foot, top, around)

    def melts_above(self, T: Array) -> NDArray[np.bool_]:
        """Return where the surface would be warmer than the melting point: it melts, (n,)."""
        T_top = np.take_along_axis(T, self.top, axis=1)[:, 0]
        return np.asarray(self.r * (self.around.sun + self.around.exchange * self.around.air) + T_top > 0.0)

    def from_above(self, melts: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Return a and b of a - b T, what comes from above into a highest layer of T [W/m2], (n,) each.

        Through a surface without mass: (sun + h (air - T)) / (1 + h r); where that melts it is at 0 deg C,
        and what it takes is left to the layer.
        """
        h, lies = self.around.exchange, np.take_along_axis(self.C, self.top, axis=1)[:, 0] > 0.0
        eased = np.where(melts, 1.0, 1.0 + h * self.r)
        a = (self.around.sun + h * self.around.air) / eased
        return np.where(lies, a, 0.0), np.where(lies & ~melts, h / eased, 0.0)

    def flows(self, T: Array, melts: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Return what flows into each layer at T, and into a place from outside [W/m2], (n, k) and (n,)."""
        between = self.g * (T[:, 1:] - T[:, :-1])
        inward = np.zeros_like(T)
        inward[:, :-1] += between
        inward[:, 1:] -= between
        a, b = self.from_above(melts)
        above = a - b * np.take_along_axis(T, self.top, axis=1)[:, 0]
        below = self.foot * ((self.around.ground or 0.0) - T[:, 0])
        _add_on_top(inward, self.top, above)
        inward[:, 0] += below
        return inward, above + below

    def solved(self, e: Array, is_held: NDArray[np.bool_], melts: NDArray[np.bool_], dt: float) -> Array:
        """Return the temperatures after `dt` [deg C], 0 where `is_held`: C T' = e + dt (flows at T')."""
        a, b = self.from_above(melts)
        diagonal, right = self.C.copy(), e.copy()
        diagonal[:, :-1] += dt * self.g
        diagonal[:, 1:] += dt * self.g
        _add_on_top(diagonal, self.top, dt * b)
        _add_on_top(right, self.top, dt * a)
        diagonal[:, 0] += dt * self.foot
        right[:, 0] += dt * self.foot * (self.around.ground or 0.0)
        free = ~is_held
        off = -dt * self.g
        return _tridiagonal(
            np.where(free[:, 1:], off, 0.0),
            np.where(free, diagonal, 1.0),
            np.where(free[:, :-1], off, 0.0),
            np.where(free, right, 0.0),
        )


def _add_on_top(values: Array, top: NDArray[np.int64], more: Array) -> None:
    np.put_along_axis(values, top, np.take_along_axis(values, top, axis=1) + more[:, None], axis=1)


def _tridiagonal(low: Array, diagonal: Array, up: Array, right: Array) -> Array:
    """Return the solutions of n tridiagonal systems of k unknowns, (n, k) (Thomas)."""
    for k in range(1, diagonal.shape[1]):
        ratio = low[:, k - 1] / diagonal[:, k - 1]
        diagonal[:, k] -= ratio * up[:, k - 1]
        right[:, k] -= ratio * right[:, k - 1]
    T = np.empty_like(diagonal)
    T[:, -1] = right[:, -1] / diagonal[:, -1]
    for k in range(diagonal.shape[1] - 2, -1, -1):
        T[:, k] = (right[:, k] - up[:, k] * T[:, k + 1]) / diagonal[:, k]
    return T


def warmed(layers: Layers, around: Surroundings, dt: float) -> tuple[Array, Array]:
    """Return the enthalpy of layers [J/m2] (n, k) after `dt` [s], and what came in from outside [J/m2], (n,).

    layers: `packed`. Implicit Euler: C T' = e + dt (flows at T'), or T' = 0 for what is between ice and
    water; which layers these are is found in a few rounds. What flows at T' is booked: nothing is lost.
    """
    heat, e, there = Conduction.of(layers, around), enthalpy(layers), layers.mass > 0.0
    T, is_mush = np.minimum(layers.temperature, 0.0), e > 0.0
    for _ in range(ROUNDS):
        melts = heat.melts_above(T)
        T = heat.solved(e, is_mush | ~there, melts, dt)
        inward, outside = heat.flows(T, melts)
        wrong = there & np.where(is_mush, e + dt * inward < 0.0, T > 0.0)
        if not wrong.any() and np.array_equal(melts, heat.melts_above(T)):
            break
        is_mush = np.where(wrong, ~is_mush, is_mush)
        T = np.minimum(T, 0.0)
    inward, outside = heat.flows(np.minimum(T, 0.0), melts)
    return np.where(there, e + dt * inward, 0.0), dt * outside


def melted(layers: Layers, e: Array) -> Array:
    """Return the thickness of layers [m] (n, k) whose enthalpy became `e` [J/m2].

    What is left of the ice keeps its pores, and what freezes fills some.
    """
    left = 1.0 - np.clip(e / np.where(layers.mass > 0.0, layers.mass * LATENT, 1.0), 0.0, 1.0)
    share = left / np.where(layers.liquid < 1.0, 1.0 - layers.liquid, 1.0)
    return layers.thickness * np.minimum(share, 1.0)


def seeped(layers: Layers, thickness: Array, e: Array) -> tuple[Layers, Array, Array]:
    """Let water beyond what pores hold seep down, freeze where it is cold, and leave at the foot.

    layers: `packed`, before they became as thick [m] and had the enthalpy e [J/m2] that are given, (n, k)
    Returns the layers, and mass [kg/m2] and enthalpy [J/m2] of what ran off, (n,) each.
    """
    thickness, mass, e = thickness.copy(), layers.mass, e.copy()
    comes, brings = np.zeros(len(mass)), np.zeros(len(mass))
    for k in range(mass.shape[1] - 1, -1, -1):
        mass[:, k] += comes
        e[:, k] += brings
        water = np.clip(e[:, k] / LATENT, 0.0, mass[:, k])
        ice = mass[:, k] - water
        lies = (ice > 0.0) & (thickness[:, k] > 0.0)
        thickness[:, k] = np.where(lies, np.maximum(thickness[:, k], ice / ICE), 0.0)
        pores = thickness[:, k] - ice / ICE
        comes = np.where(lies, np.maximum(water - HOLDS * WATER * pores, 0.0), mass[:, k])
        brings = np.where(lies, LATENT * comes, e[:, k])
        mass[:, k] -= comes
        e[:, k] -= brings
    there = thickness > 0.0
    safe = np.where(there, mass, 1.0)
    now = layers.but(
        thickness=thickness,
        density=np.where(there, mass / np.where(there, thickness, 1.0), layers.density),
        temperature=np.where(there, np.minimum(e, 0.0) / (safe * C_ICE), 0.0),
        liquid=np.where(there, np.clip(e / (safe * LATENT), 0.0, 1.0), 0.0),
    )
    return now, comes, brings
