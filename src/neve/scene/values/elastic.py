"""Convert between the constants of isotropic linear elasticity."""

from __future__ import annotations


def lame(E: float, nu: float) -> tuple[float, float]:
    """Return Lame's constants mu = E / 2 (1 + nu) and lam = E nu / (1 + nu)(1 - 2 nu) [Pa].

    E: Young's modulus [Pa]. nu: Poisson's ratio [1], below 1/2.
    """
    return E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))


def bulk_modulus(E: float, nu: float) -> float:
    """Return K = E / 3 (1 - 2 nu) [Pa]: pressure per relative loss of volume."""
    return E / (3 * (1 - 2 * nu))


def p_wave_modulus(E: float, nu: float) -> float:
    """Return M_c = lam + 2 mu = E (1 - nu) / (1 + nu)(1 - 2 nu) [Pa]: stress per strain in uniaxial strain.

    A pressure wave travels at sqrt(M_c / rho).
    """
    return E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
