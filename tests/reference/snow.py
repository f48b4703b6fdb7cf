"""Snow of Stomakhin et al. 2013: fixed corotated elasticity, a clamp on the stretches, hardening."""

from dataclasses import dataclass, fields

import numpy as np


@dataclass(frozen=True)
class Snow:
    """Parameters of the law; each a number or one value per particle (n,)."""

    E0: float | np.ndarray = 1.4e5  # Young's modulus [Pa], stiffness factor included
    nu: float | np.ndarray = 0.2  # Poisson's ratio [1]
    xi: float | np.ndarray = 10.0  # hardening [1]
    theta_c: float | np.ndarray = 2.5e-2  # critical compression [1]
    theta_s: float | np.ndarray = 7.5e-3  # critical stretch [1]
    rho0: float | np.ndarray = 400.0  # density at rest [kg/m3]
    J_P_min: float | np.ndarray = 0.6  # lower bound of J_P, inside the exponent only [1]
    J_P_max: float | np.ndarray = 20.0  # upper bound, in the state too [1]

    @property
    def mu0(self):
        return self.E0 / (2 * (1 + self.nu))

    @property
    def lam0(self):
        return self.E0 * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def M_c(self):
        """P-wave modulus lam + 2 mu [Pa] of snow that has not hardened."""
        return self.lam0 + 2 * self.mu0

    def hardening(self, J_P):
        return np.exp(self.xi * (1 - np.clip(J_P, self.J_P_min, self.J_P_max)))

    def take(self, index):
        """Pick one row per particle from a table of materials (every field an array)."""
        return Snow(**{f.name: np.asarray(getattr(self, f.name))[index] for f in fields(self)})


def polar_svd(F):
    """Decompose F = U diag(sigma) V^T with rotations U, V; a reflection makes the smallest sigma negative."""
    U, sigma, Vt = np.linalg.svd(F)
    sigma = sigma.copy()
    for Q in (U, np.swapaxes(Vt, -1, -2)):  # the views write through
        flip = np.linalg.det(Q) < 0
        Q[flip, :, 2] *= -1
        sigma[flip, 2] *= -1
    return U, sigma, np.swapaxes(Vt, -1, -2)


def rotation(F):
    """Find R of the polar decomposition F = R S."""
    U, _, V = polar_svd(F)
    return U @ np.swapaxes(V, -1, -2)


def energy(F_E, J_P, snow):
    """Psi = mu |F_E - R_E|^2 + lam/2 (J_E - 1)^2, per volume at rest [J/m3] (n,)."""
    h = snow.hardening(J_P)
    J_E = np.linalg.det(F_E)
    return h * (snow.mu0 * ((F_E - rotation(F_E)) ** 2).sum((-1, -2)) + 0.5 * snow.lam0 * (J_E - 1) ** 2)


def kirchhoff(F_E, J_P, snow):
    """tau = 2 mu (F_E - R_E) F_E^T + lam (J_E - 1) J_E I [Pa] (n, 3, 3)."""
    h = snow.hardening(J_P)
    J_E = np.linalg.det(F_E)
    deviation = (F_E - rotation(F_E)) @ np.swapaxes(F_E, -1, -2)
    return column(2 * h * snow.mu0) * deviation + column(h * snow.lam0 * (J_E - 1) * J_E) * np.eye(3)


def return_map(F_trial, J_P, snow):
    """Clamp the elastic stretches to [1 - theta_c, 1 + theta_s]; what is cut off becomes plastic: J_P."""
    U, sigma, V = polar_svd(F_trial)
    kept = np.clip(sigma, column(1 - snow.theta_c, 1), column(1 + snow.theta_s, 1))
    F_E = (U * kept[:, None, :]) @ np.swapaxes(V, -1, -2)
    return F_E, np.minimum(J_P * (sigma / kept).prod(-1), snow.J_P_max)


def column(values, axes=2):
    """Append axes, so that one value per particle multiplies that particle's vector or matrix."""
    values = np.asarray(values, dtype=float)
    return values.reshape(values.shape + (1,) * axes) if values.ndim else values
