"""Let days pass over snow that lies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from neve.ageing.settling import settled
from neve.ageing.warming import Surroundings, enthalpy, melted, packed, seeped, warmed
from neve.heat.sintering import grown
from neve.snowfall.cover import Cover
from neve.snowfall.layers import Layers

Array = NDArray[np.float64]

DAY, HOUR = 86400.0, 3600.0
WARMEST = 14.0
"""Hour of the day at which the air is warmest."""
STEP = 600.0
"""Longest step [s]."""


@dataclass(frozen=True)
class Weather:
    """Say what the days are like; they begin at midnight.

    air: mean temperature [deg C]; swing: how far that of the warmest hour, 14, is above it [K]; sun: power on
    level ground at noon [W/m2], a half sine from 6 to 18 h; albedo: share of it that snow throws back;
    exchange: with the air [W/(m2 K)]; ground: temperature at the foot of the snow [deg C], None: insulated
    """

    air: float = -5.0
    swing: float = 0.0
    sun: float = 0.0
    albedo: float = 0.8
    exchange: float = 15.0
    ground: float | None = None

    def at(self, t: float, open_sky: Array) -> Surroundings:
        """Return what gives heat to places of which the sky is open to a share (n,), at the time `t` [s]."""
        hour = t / HOUR % 24.0
        air = self.air + self.swing * math.cos(2.0 * math.pi * (hour - WARMEST) / 24.0)
        sun = self.sun * (1.0 - self.albedo) * max(0.0, math.sin(math.pi * (hour - 6.0) / 12.0))
        return Surroundings(air, self.exchange, sun * open_sky, self.ground)


@dataclass(frozen=True)
class Balance:
    """Say where mass [kg] and heat [J] have gone: before + came = after + ran off, to rounding.

    Heat is zero for ice at the melting point; came: from air, sun and ground.
    """

    mass_before: float
    mass_after: float
    mass_ran_off: float
    heat_before: float
    heat_came: float
    heat_after: float
    heat_ran_off: float


def aged(
    layers: Layers,
    weather: Weather,
    seconds: float,
    gravity: float = 9.81,
    open_sky: Array | None = None,
    told: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Layers, Balance]:
    """Return what so many seconds of weather make of layers, and where mass and heat went, for 1 m2 a place.

    In steps of at most 600 s: heat flows and snow melts, water seeps, snow settles, and sinters. None slides,
    and none falls. open_sky: share of the sun that reaches each place (n,), 1 for all;
    told: hears how many days are over
    """
    steps, days = max(1, math.ceil(seconds / STEP)), max(1, math.ceil(seconds / DAY))
    dt = seconds / steps
    now = packed(layers)
    sky = np.ones(len(now.thickness)) if open_sky is None else np.clip(open_sky, 0.0, 1.0)
    mass, heat = float(now.mass.sum()), float(enthalpy(now).sum())
    came = ran_off = heat_off = 0.0
    for step in range(steps):
        e, outside = warmed(now, weather.at((step + 0.5) * dt, sky), dt)
        now, water, its_heat = seeped(now, melted(now, e), e)
        came, ran_off = came + float(outside.sum()), ran_off + float(water.sum())
        heat_off += float(its_heat.sum())
        now = settled(packed(now), dt, gravity)
        now = now.but(growth=grown(now.growth, now.density, now.temperature, dt), age=now.age + dt)
        if (step + 1) * days // steps > step * days // steps:
            told((step + 1) * days // steps, days)
    return now, Balance(
        mass, float(now.mass.sum()), ran_off, heat, came, float(enthalpy(now).sum()), heat_off
    )


def aged_cover(
    cover: Cover, weather: Weather, seconds: float, told: Callable[[int, int], None] = lambda done, of: None
) -> tuple[Cover, Balance]:
    """Return the cover after so many seconds, and its balance.

    Sheltered places get as small a share of the sun as they got of the snow.
    """
    layers, balance = aged(cover.layers, weather, seconds, open_sky=cover.share, told=told)
    area = cover.raster.cell**2
    scaled = Balance(**{name: value * area for name, value in vars(balance).items()})
    return replace(cover, layers=layers, depth=layers.depth), scaled
