"""Light and colours that film and page share: sun, sky, paint, and how finely light sees the snow."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from neve.colliders.solid import Solid
    from neve.scene.schema.scene import Light, Numerics

Triple = tuple[float, float, float]

STEEL: Triple = (0.20, 0.23, 0.27)
"""Paint of a solid without a colour of its own, linear: grey-blue steel."""

# What a strength of one means: light on a surface that faces the sun, and on open level ground, in the
# units in which the film's curve shows 1 as bright sunlit snow.
_SUN = 1.9
_SKY = 0.5


def sun_direction(light: Light) -> Triple:
    """Return the unit vector towards the sun."""
    return light.towards_sun


def sun_color(light: Light) -> Triple:
    """Return the sun's light on a surface that faces it: red, green and blue."""
    return _scaled(light.sun_color, _SUN * light.sun_strength)


def sky_color(light: Light) -> Triple:
    """Return the sky's light on open level ground: red, green and blue."""
    return _scaled(light.sky_color, _SKY * light.sky_strength)


def particle_volume(numerics: Numerics, radius: float | None = None) -> float:
    """Return the volume that one particle takes at rest [m3]: dx^3 over the particles of a cell.

    radius: of the particles [m], of a solver that has its own: they take the cube of twice as much.
    """
    if radius is None or 2 * radius == numerics.spacing:  # alike but for rounding, which pictures show
        return numerics.dx**3 / numerics.particles_per_cell
    return (2 * radius) ** 3


def density_cell(numerics: Numerics, radius: float | None = None) -> float:
    """Return the cell size of the density that light passes through [m].

    Fine enough for shadows of clods, coarse enough that solid snow has no holes.
    """
    return max(0.75 * numerics.dx, 1.5 * math.cbrt(particle_volume(numerics, radius)))


def is_ground(solid: Solid) -> bool:
    """Say whether a solid is drawn as frozen ground: an endless one without colour and finish."""
    return solid.endless and solid.color is None and solid.finish is None


def _scaled(color: Triple, factor: float) -> Triple:
    return color[0] * factor, color[1] * factor, color[2] * factor
