"""Keep what the engine drops when a robot becomes part of a larger model, or name it.

MuJoCo keeps each element's own angles, Euler sequences, limits and inertia rules, but applies to the whole
model what a compiler does last: `settotalmass`, and how the ranges of muscles are found (`lengthrange`). The
options, which a model has once, are those of the scene. Measured in tests/verification/rigid.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from neve.rigid.engine import engine

PHYSICS = ("gravity", "wind", "magnetic", "density", "viscosity")
"""Options that say in what world a robot moves; the others say how the engine computes."""
OVERRIDES = ("o_margin", "o_solref", "o_solimp", "o_friction")
"""Options of contacts that count with the flag `override`."""
DISABLED = (
    *(
        "CONSTRAINT",
        "EQUALITY",
        "FRICTIONLOSS",
        "LIMIT",
        "CONTACT",
        "SPRING",
        "DAMPER",
        "GRAVITY",
        "CLAMPCTRL",
    ),
    *("FILTERPARENT", "ACTUATION"),
)
"""Flags of the option that take something out of the physics."""


def keep_compiled(child: Any, alone: Any) -> None:
    """Write into `child` what only its own compiler would make of it: masses, and lengths of muscles.

    `alone`: the compiled model of `child`.
    """
    if getattr(child.compiler, "settotalmass", 0.0) > 0.0:  # later engines may not have it
        child.compiler.inertiafromgeom = engine().mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
        for body in child.bodies[1:]:
            made = alone.body(body.id)
            body.explicitinertial = True
            body.mass = float(made.mass[0])
            body.ipos, body.iquat, body.inertia = made.ipos, made.iquat, made.inertia
            body.fullinertia = np.full(6, np.nan)
    for i, actuator in enumerate(child.actuators):
        if np.any(alone.actuator_lengthrange[i]):
            actuator.lengthrange = alone.actuator_lengthrange[i]


def dropped_options(child: Any, ours: Any) -> list[str]:
    """Return the options of physics that `child` sets and that those of the scene, `ours`, replace."""
    plain, found = engine().MjSpec().option, []
    override = int(engine().mjtEnableBit.mjENBL_OVERRIDE)
    overrides = OVERRIDES if child.option.enableflags & override else ()
    for name in (*PHYSICS, *overrides):
        value, usual, scene = (np.atleast_1d(getattr(o, name)) for o in (child.option, plain, ours))
        if not np.array_equal(value, usual) and not np.array_equal(value, scene):
            found.append(f"{name} = {' '.join(f'{number:g}' for number in value)}")
    bits = engine().mjtDisableBit
    off = int(child.option.disableflags) & ~int(ours.disableflags)
    found += [
        f'flag {name.lower()} = "disable"' for name in DISABLED if off & int(getattr(bits, f"mjDSBL_{name}"))
    ]
    if child.option.disableactuator:
        groups = [str(i) for i in range(31) if child.option.disableactuator & (1 << i)]
        found.append(f"actuatorgroupdisable = {' '.join(groups)}")
    return found
