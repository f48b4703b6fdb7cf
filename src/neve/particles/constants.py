"""What a named snow is to particles in contact: constants of contacts from those of the snow's law."""

from __future__ import annotations

import math
from typing import NamedTuple

from neve import _core
from neve.scene.schema.scene import Snow

PACKING = 0.55
"""Share of space that spheres fill in snow at birth [1]: a loose random packing, below jamming at 0.64."""
BOND_GAP = 0.3
"""Gap over the sum of the radii across which snow is bonded at birth [1]."""
TANGENTIAL = 0.5
"""Stiffness of a contact along its plane over that across it [1]; our choice."""
DAMPING = 0.1
"""Damping ratio of a contact between two equal particles [1]."""
FRICTION = math.tan(math.radians(38.0))
"""Coulomb's coefficient of snow whose law has none [1]; 38 degrees as a port of Goswami et al. 2019 [C]."""
ICE = _core.ice_density
"""Density at which a particle is compacted no more [kg/m3]."""
HARDENING = 100.0
"""Rise of density by which the yield pressure grows e-fold [kg/m3]; a port of Goswami et al. 2019 [C]."""
SWINGING = 10.0
"""Speed over sleep_speed below which particles that hang on what rests may sleep with it [1]; our choice."""
NEVER = 1e30
"""A strain or a pressure [Pa] that nothing reaches."""


class ContactConstants(NamedTuple):
    """Constants of one snow, in the order in which the core takes them.

    modulus: stiffness of a contact over the radius [Pa]; friction: Coulomb's coefficient [1]; bond_strain:
    stretch of a pair over its distance at which its bond breaks [1]; yield_pressure: above which a particle
    is compacted, at birth [Pa].
    """

    modulus: float
    friction: float
    bond_strain: float
    yield_pressure: float


def contact_constants(snow: Snow) -> ContactConstants:
    """Return the constants of contacts for `snow`.

    The modulus is Young's. Tension breaks bonds, and pressure compacts, where the snow's own law would flow,
    by the constants that the law has:

    * cohesion, friction_angle: tension is the cohesion, no compaction; tan(friction_angle)
    * p0, beta, M: tension beta p0, pressure p0; friction of the slope M, sin phi = 3 M / (6 + M)
    * theta_c, theta_s: strain theta_s, pressure E0 theta_c; never without plasticity
    """
    c = snow.constants()
    if "friction_angle" in c:
        friction = math.tan(math.radians(c["friction_angle"]))
        return ContactConstants(snow.E0, friction, c["cohesion"] / snow.E0, NEVER)
    if "p0" in c:
        sine = min(3.0 * c["M"] / (6.0 + c["M"]), 0.99)
        friction = sine / math.sqrt(1.0 - sine * sine)
        return ContactConstants(snow.E0, friction, c["beta"] * c["p0"] / snow.E0, c["p0"])
    if snow.plasticity == "none" or "theta_s" not in c:
        return ContactConstants(snow.E0, FRICTION, NEVER, NEVER)
    return ContactConstants(snow.E0, FRICTION, c["theta_s"], snow.E0 * c["theta_c"])


def without_counterpart(snow: Snow) -> tuple[str, ...]:
    """Return the constants of `snow` that contacts do not have.

    A network of springs has a nu of its own, and compaction a growth and a bound of its own.
    """
    return tuple(name for name in ("nu", "xi", "J_P_min", "J_P_max") if name in snow.constants())


def radius_at_birth(volume: float) -> float:
    """Return the radius of a particle [m] that stands for `volume` [m3] of snow: 4/3 pi r^3 = PACKING V."""
    return float((PACKING * volume * 3.0 / (4.0 * math.pi)) ** (1.0 / 3.0))
