"""Grains of Drucker and Prager's law in plane strain: what angles and strengths they have."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve.simulation import Simulation
from neve.validate.scenes import column

Array = NDArray[np.float64]

G = 9.81


def cone(degrees: float) -> float:
    """Return M = 6 sin phi / (3 - sin phi), the slope of the cone that fits triaxial compression [1]."""
    sine = np.sin(np.radians(degrees))
    return float(6 * sine / (3 - sine))


def plane_strain(degrees: float, cohesion: float = 0.0) -> tuple[float, float]:
    """Return the friction angle [degrees] and the cohesion [Pa] that the cone has in plane strain.

    Flow at constant volume leaves the stress across the plane at the mean of the other two; then q = sqrt 3
    times the largest shear stress and p is the mean of the two: sin phi* = M / sqrt 3. The tip of the cone,
    p_t = c / tan phi, stays where it is: c* = p_t tan phi*.
    """
    sine = cone(degrees) / np.sqrt(3)
    angle = float(np.degrees(np.arcsin(sine)))
    return angle, float(cohesion / np.tan(np.radians(degrees)) * np.tan(np.radians(angle)))


def sliding(degrees: float) -> float:
    """Return the slope [degrees] on which the cone shears at constant volume: tan theta = M / sqrt 3.

    In steady shear the stress has the axes of the flow, at 45 degrees to the slope: the shear stress is
    q / sqrt 3 and the pressure on the slope is p.
    """
    return float(np.degrees(np.arctan(cone(degrees) / np.sqrt(3))))


def restless(sim: Simulation) -> float:
    """Return the root mean square speed of the particles [m/s]."""
    return float(np.sqrt((column(sim, "v") ** 2).sum(1).mean()))


def front(sim: Simulation, gap: float) -> float:
    """Return how far the snow reaches along x [m] before the first gap wider than `gap` [m]."""
    x = np.sort(column(sim, "x")[:, 0])
    wide = np.flatnonzero(np.diff(x) > gap)
    return float(x[wide[0]] if len(wide) else x[-1])


def surface(sim: Simulation, width: float) -> tuple[Array, Array]:
    """Return places x [m] and the heights of the surface there [m], from strips of `width` [m] each."""
    x = column(sim, "x")
    strip = np.floor(x[:, 0] / width).astype(np.int64)
    found = np.unique(strip[strip >= 0])
    top = np.asarray([np.sort(x[strip == k, 2])[-2:].mean() for k in found])
    return np.asarray((found + 0.5) * width), top
