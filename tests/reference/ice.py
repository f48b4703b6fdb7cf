"""Ice in NumPy: the pressure and energy of snow that flows, beyond the density of ice."""

import numpy as np

K, DENSITY, FULL, LEAST_PRESSED = 8.9e9, 917.0, 0.1, 0.9  # [Pa], [kg/m3], [1], [1]


def volume(p):
    """J_ice = min(m / (V0 917 kg/m3), 0.9), the volume of ice over that at rest (n,)."""
    return np.minimum(p.m / (p.V0 * DENSITY), LEAST_PRESSED)


def beyond(p):
    """z = ln(J_ice / J), at least 0; and 0 without plastic flow (n,)."""
    z = np.maximum(np.log(volume(p) / (np.linalg.det(p.F_E) * p.J_P)), 0)
    return np.where(np.asarray(p.law.plasticity) == "snow", z, 0)


def pressure(z):
    """dU/dz over J_ice, with a bulk modulus that grows as z^3 to K at z = 0.1 and stays [Pa]."""
    return np.where(z < FULL, K * FULL / 4 * (z / FULL) ** 4, K * (FULL / 4 + z - FULL))


def energy(z):
    """U(z) over J_ice [J/m3]."""
    past = z - FULL
    return np.where(
        z < FULL, K * FULL**2 / 20 * (z / FULL) ** 5, K * (FULL**2 / 20 + FULL / 4 * past + past**2 / 2)
    )
