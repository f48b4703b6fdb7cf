"""Energy and Kirchhoff stress of the three elasticities, written with tensors, not principal stretches.

Each has two functions of F_E (n, 3, 3) and the Lame constants mu, lam (one number or (n,)) [Pa].
"""

import numpy as np

from reference.polar import column, rotation, transpose


def square(A):
    """||A||^2 of each matrix."""
    return (A**2).sum((-1, -2))


class FixedCorotated:
    """Psi = mu |F - R|^2 + lam/2 (J - 1)^2; tau = 2 mu (F - R) F^T + lam (J - 1) J I."""

    @staticmethod
    def energy(F, mu, lam):
        return mu * square(F - rotation(F)) + 0.5 * lam * (np.linalg.det(F) - 1) ** 2

    @staticmethod
    def stress(F, mu, lam):
        J = np.linalg.det(F)
        return 2 * column(mu) * (F - rotation(F)) @ transpose(F) + column(lam * (J - 1) * J) * np.eye(3)


class NeoHookean:
    """Psi = mu/2 (|F|^2 - 3) - mu ln J + lam/2 ln^2 J; tau = mu (F F^T - I) + lam ln J I."""

    @staticmethod
    def energy(F, mu, lam):
        ln_J = np.log(np.linalg.det(F))
        return 0.5 * mu * (square(F) - 3) - mu * ln_J + 0.5 * lam * ln_J**2

    @staticmethod
    def stress(F, mu, lam):
        ln_J = np.log(np.linalg.det(F))
        return column(mu) * (F @ transpose(F) - np.eye(3)) + column(lam * ln_J) * np.eye(3)


class Hencky:
    """Psi = mu |eps|^2 + lam/2 tr^2 eps with eps = ln(F F^T) / 2; tau = 2 mu eps + lam tr eps I."""

    @staticmethod
    def strain(F):
        b, Q = np.linalg.eigh(F @ transpose(F))
        return (Q * (0.5 * np.log(b))[:, None, :]) @ transpose(Q)

    @classmethod
    def energy(cls, F, mu, lam):
        eps = cls.strain(F)
        return mu * square(eps) + 0.5 * lam * np.trace(eps, axis1=-2, axis2=-1) ** 2

    @classmethod
    def stress(cls, F, mu, lam):
        eps = cls.strain(F)
        return 2 * column(mu) * eps + column(lam * np.trace(eps, axis1=-2, axis2=-1)) * np.eye(3)
