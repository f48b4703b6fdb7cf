"""Wind moves snow that lies: it erodes where it blows freely, and drops it where it is slowed.

A simple model.
The flux of saltating snow along the wind relaxes to what the local wind can carry, over a length of its own.
The local wind is that of the open field, slowed in the lee of what stands upwind and right before obstacles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KARMAN, ROUGHNESS, HEIGHT = 0.4, 2e-4, 10.0
"""Of u = u* / kappa ln(z / z0): kappa [1], z0 of snow and the height of the wind [m] (from memory)."""
THRESHOLD = 0.25
"""Friction velocity from which fresh dry snow moves [m/s] (Pomeroy and Gray 1990, from memory)."""
SALTATION, AIR = 0.68, 1.3
"""Constant of the flux of saltating snow [m/s] (the same), density of air [kg/m3]."""
GRAVITY = 9.81
"""[m/s2]"""
LENGTH = 1.0
"""Over which the flux follows the wind [m]: our choice."""
FASTEST = 1.3
"""Wind on crests over that of the open field, at most [1]: our choice."""
LEE = 0.3
"""Slope up to the horizon upwind at which the wind is still [1]: our choice."""
FRONT, STEEP, LEFT = 0.4, 1.2, 0.8
"""Slope up to the horizon downwind from which it slows the wind, that from which no more, and what is left of
the wind there [1]: our choice, so that most of the snow flies over an obstacle into its lee."""
REACH = 30.0
"""How far a horizon is sought [m]."""
MOST_STEPS, MOST_CHANGE = 1000, 0.1
"""Steps at most, and change of the depth in one [cells]."""


def friction_velocity(wind: tuple[float, float]) -> float:
    """Return u* of the open field [m/s] in a wind 10 m above the ground [m/s]."""
    return KARMAN * math.hypot(*wind) / math.log(HEIGHT / ROUGHNESS)


def carried(u: Array) -> Array:
    """Return the flux of saltating snow [kg/(m s)] at the friction velocity u [m/s]: Pomeroy and Gray 1990.

    0.68 rho_air u_t (u^2 - u_t^2) / (g u), 0 below the threshold u_t.
    """
    safe = np.maximum(u, THRESHOLD)
    return np.asarray(SALTATION * AIR * THRESHOLD * (safe**2 - THRESHOLD**2) / (GRAVITY * safe))


@dataclass(frozen=True)
class Field:
    """Hold a raster whose rows and columns run with the wind.

    cell: edge [m]; along: unit vector of the wind, both parts >= 0 [1]; flip: axes that were turned round
    """

    cell: float
    along: tuple[float, float]
    flip: tuple[int, ...]

    @classmethod
    def of(cls, cell: float, wind: tuple[float, float]) -> Field:
        """Return that of a wind [m/s]."""
        speed = math.hypot(*wind)
        flip = tuple(axis for axis in (0, 1) if wind[axis] < 0.0)
        return cls(cell, (abs(wind[0]) / speed, abs(wind[1]) / speed), flip)

    def turned(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values (nx, ny) with the axes along the wind, or back."""
        return np.flip(values, self.flip)

    @property
    def width(self) -> float:
        """Of a cell across the wind [m]."""
        return self.cell * sum(self.along)

    def slowed(self, top: Array) -> Array:
        """Return the wind over surfaces of height `top` (nx, ny) [m] over that of the open field [1].

        1 - S / 0.3, S the steepest slope up to a horizon upwind within 30 m (Winstral and Marks 2002 measure
        shelter so), less than 0 on crests, where the wind is up to 1.3 times as fast; before an obstacle,
        where the slope up to a horizon downwind is 1.2 or more, 0.8 of that.
        """
        up, down = np.full_like(top, -np.inf), np.zeros_like(top)
        for k in range(1, 1 + min(max(top.shape), round(REACH / self.cell))):
            i, j = (round(k * part) for part in self.along)
            far = self.cell * math.hypot(i, j)
            if i >= top.shape[0] or j >= top.shape[1]:
                break
            near, away = top[: top.shape[0] - i, : top.shape[1] - j], top[i:, j:]
            np.maximum(up[i:, j:], (near - away) / far, out=up[i:, j:])
            there = down[: top.shape[0] - i, : top.shape[1] - j]
            np.maximum(there, (away - near) / far, out=there)
        front = 1.0 - (1.0 - LEFT) * np.clip((down - FRONT) / (STEEP - FRONT), 0.0, 1.0)
        up[np.isinf(up)] = 0.0  # at the rim, where nothing is known of what stands upwind
        return np.clip(1.0 - up / LEE, 0.0, FASTEST) * front

    def moved(
        self, limit: Array, store: Array, is_void: NDArray[np.bool_], inflow: float
    ) -> tuple[Array, float, float]:
        """Return what comes to lie in each cell [kg/s] (nx, ny), what flows in over the rim, and out [kg/s].

        limit: what the wind can carry through each cell [kg/s]; store: the most that each can give [kg/s];
        is_void: cells over which snow flies on; inflow: through each cell of the open field upwind [kg/s].
        What flows out of a cell goes to the next along both axes, in shares of the wind's parts: nothing is
        lost.
        """
        nx, ny = limit.shape
        px = self.along[0] / sum(self.along)
        keep = math.exp(-(self.cell**2) / self.width / LENGTH)
        flux, gain = np.zeros((nx + 1, ny + 1)), np.zeros((nx, ny))
        flux[0, :ny] += px * inflow
        flux[:nx, 0] += (1.0 - px) * inflow
        came = inflow * (px * ny + (1.0 - px) * nx)
        for d in range(nx + ny - 1):
            i = np.arange(max(0, d - ny + 1), min(nx, d + 1))
            j = d - i
            into = flux[i, j]
            out = np.minimum(limit[i, j] + (into - limit[i, j]) * keep, into + store[i, j])
            out = np.where(is_void[i, j], into, out)
            gain[i, j] = into - out
            flux[i + 1, j] += px * out
            flux[i, j + 1] += (1.0 - px) * out
        went = float(flux[nx, :ny].sum() + flux[:nx, ny].sum())
        return gain, came, went


def drifted(
    top: Array, depth: Array, density: float, cell: float, wind: tuple[float, float], seconds: float
) -> tuple[Array, float, float, float]:
    """Return the depth (nx, ny) [m] after wind has blown for a while, how long, and what came and went [m3].

    top: heights of the surfaces under the sky without snow (nx, ny) [m], minus infinity where there is none;
    wind: 10 m above the ground [m/s]. It blows until the depth has changed by a tenth of a cell somewhere,
    or for `seconds`; snow comes in over the rim as from an open field.
    """
    field, open_u = Field.of(cell, wind), friction_velocity(wind)
    is_there = np.isfinite(top)
    ground = np.where(is_there, top, top[is_there].min() if is_there.any() else 0.0)
    lies, height = field.turned(depth), field.turned(ground)
    limit = carried(open_u * field.slowed(height + lies)) * field.width
    inflow = float(carried(np.array(open_u))) * field.width
    area, void = cell * cell, field.turned(~is_there)
    dt = seconds
    for _ in range(2):
        gain, came, went = field.moved(limit, lies * density * area / dt, void, inflow)
        fastest = float(np.abs(gain).max()) / (density * area)
        if fastest * dt <= MOST_CHANGE * cell:
            break
        dt = MOST_CHANGE * cell / fastest
    scale = dt / (density * area)
    return field.turned(np.maximum(lies + gain * scale, 0.0)), dt, came * dt / density, went * dt / density
