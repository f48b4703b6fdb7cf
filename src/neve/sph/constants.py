"""What a named snow is to smoothed particles, and the numbers of the solver."""

from __future__ import annotations

from neve.scene.schema.scene import Snow

SUPPORT = 2.0
"""Support of the kernel over the distance of particles [1]: h = 4 R of Gissler et al. 2020, R half of it."""
TOLERANCE = 3e-5
"""Residual of both solves at which they end [1]: mean |rho_0 - rho* - A p| / rho_0, and |b - M a| / |b|."""
LARGEST = 3e-4
"""Largest |rho_0 - rho* - A p| / rho_0 of a particle at which the solve for pressure ends [1]."""
SWING = 1.8
"""Largest omega dt of the zero-energy (hourglass) mode of pressed snow [1]: at 2 it grows."""
MOST_PRESSURE, MOST_SHEAR = 300, 150
"""Iterations after which a solve has failed."""
TRIES = 16
"""Attempts at a step, each of half the length of the one before."""
NUMERICAL_VISCOSITY = 0.1
"""What water has besides its own viscosity, over density and distance of particles [m/s]: our choice. Without
any, particles of water that is at rest boil."""
NEVER = 0.99
"""A strain that no snow reaches before it is crushed."""


def law_constants(snow: Snow) -> dict[str, float]:
    """Return the constants of the law that smoothed particles follow, that of Stomakhin et al. 2013.

    Strains are clamped to [-theta_c, theta_s], and moduli grow by exp(xi (1 - J_P)). Of snows with

    * theta_c, theta_s, xi: these; with `plasticity = "none"` nothing flows
    * p0, beta, M, xi: the strains at which p0 is reached by equal compression, theta_c = p0 (1 - 2 nu) / E0,
      and its tension beta p0, theta_s = beta theta_c; xi; and J_P_min and J_P_max
    * cohesion, friction_angle: theta_s = cohesion / E0; nothing is crushed, nor hardens
    """
    c = snow.constants()
    common = {name: c[name] for name in ("rho0", "E0", "nu")}
    if "theta_c" in c:
        return {**c}
    if "p0" in c:
        theta_c = min(c["p0"] * (1.0 - 2.0 * c["nu"]) / c["E0"], NEVER)
        xi = min(c.get("xi", 0.0), 0.5 / theta_c)
        bounds = {name: value for name, value in c.items() if name in {"J_P_min", "J_P_max"}}
        return {**common, **bounds, "theta_c": theta_c, "theta_s": c["beta"] * theta_c, "xi": xi}
    return {**common, "theta_c": NEVER, "theta_s": c["cohesion"] / c["E0"], "xi": 0.0}


def without_counterpart(snow: Snow) -> tuple[str, ...]:
    """Return the constants of `snow` that smoothed particles do not have: friction, bounds without xi."""
    c = snow.constants()
    bounds = () if "xi" in c else ("J_P_min", "J_P_max")
    return tuple(name for name in ("M", "friction_angle", *bounds) if name in c)
