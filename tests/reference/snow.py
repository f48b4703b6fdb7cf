"""Snow: its constants, and energy, stress and return map by the law that it names."""

from dataclasses import dataclass, fields

import numpy as np

from reference import plasticity
from reference.elasticity import FixedCorotated, Hencky, NeoHookean
from reference.polar import column, polar_svd, rotation

ELASTICITIES = {
    "stomakhin2013": FixedCorotated,
    "neo_hookean": NeoHookean,
    "hencky": Hencky,
    "drucker_prager": Hencky,
    "cam_clay": Hencky,
}
"""The laws, each with its elasticity."""
OWN_PLASTICITY = {"drucker_prager": plasticity.drucker_prager, "cam_clay": plasticity.cam_clay}
CLAMPED = {"snow": plasticity.clamp, "none": plasticity.nothing}


@dataclass(frozen=True)
class Snow:
    """Parameters of a law; each a number (or word) or one per particle (n,)."""

    law: str | np.ndarray = "stomakhin2013"  # a key of ELASTICITIES
    plasticity: str | np.ndarray = "snow"  # "snow" | "none"; drucker_prager and cam_clay have their own
    E0: float | np.ndarray = 1.4e5  # Young's modulus [Pa], stiffness factor included
    nu: float | np.ndarray = 0.2  # Poisson's ratio [1]
    xi: float | np.ndarray = 10.0  # hardening [1]
    theta_c: float | np.ndarray = 2.5e-2  # critical compression [1]
    theta_s: float | np.ndarray = 7.5e-3  # critical stretch [1]
    rho0: float | np.ndarray = 400.0  # density at rest [kg/m3]
    J_P_min: float | np.ndarray = 0.6  # lower bound of J_P, inside the hardening only [1]
    J_P_max: float | np.ndarray = 20.0  # upper bound, in the state too [1]
    friction_angle: float | np.ndarray = 35.0  # of drucker_prager [degrees]
    cohesion: float | np.ndarray = 0.0  # of drucker_prager [Pa]
    M: float | np.ndarray = 0.5  # slope of cam_clay [1]
    beta: float | np.ndarray = 0.0  # cohesion of cam_clay [1]
    p0: float | np.ndarray = 3e3  # strength of cam_clay at J_P = 1 [Pa]
    strength: float | np.ndarray = 1.0  # factor on theta_c and theta_s, cohesion, p0 [1]

    @property
    def mu0(self):
        return self.E0 / (2 * (1 + self.nu))

    @property
    def lam0(self):
        return self.E0 * self.nu / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def K(self):
        """Bulk modulus [Pa]."""
        return self.lam0 + 2 * self.mu0 / 3

    @property
    def M_c(self):
        """P-wave modulus lam + 2 mu [Pa] of snow that has not hardened."""
        return self.lam0 + 2 * self.mu0

    def hardening(self, J_P):
        """The factor on mu and lam."""
        factor = np.exp(self.xi * (1 - np.clip(J_P, self.J_P_min, self.J_P_max)))
        hardens = ~np.isin(self.law, list(OWN_PLASTICITY)) & (np.asarray(self.plasticity) == "snow")
        return np.where(hardens, factor, 1.0)

    @classmethod
    def table(cls, rows, index, stiffness=1.0, strength=1.0):
        """Give each particle its row `index` (n,) of `rows`, with factors on E0 and on the thresholds."""
        columns = {f.name: np.array([getattr(row, f.name) for row in rows])[index] for f in fields(cls)}
        columns["E0"] = columns["E0"] * stiffness
        columns["strength"] = columns["strength"] * strength
        return cls(**columns)


def by_law(n, snow, function):
    """Let function(rows, law, plasticity, their snow) fill arrays of n particles, law by law."""
    law, kind = (np.broadcast_to(np.asarray(a), n) for a in (snow.law, snow.plasticity))
    whole = {f.name: np.broadcast_to(np.asarray(getattr(snow, f.name)), n) for f in fields(snow)}
    for name, word in dict.fromkeys(zip(law, kind, strict=True)):
        rows = (law == name) & (kind == word)
        function(rows, name, word, Snow(**{key: value[rows] for key, value in whole.items()}))


def energy(F_E, J_P, snow):
    """Psi, elastic energy per volume at rest [J/m3] (n,)."""
    J_P, out = np.broadcast_to(J_P, len(F_E)), np.empty(len(F_E))

    def fill(rows, law, kind, own):
        h = own.hardening(J_P[rows])
        out[rows] = ELASTICITIES[law].energy(F_E[rows], h * own.mu0, h * own.lam0)
        if law == "drucker_prager":
            out[rows] += plasticity.tension(own) * np.log(np.maximum(J_P[rows], 1))

    by_law(len(F_E), snow, fill)
    return out


def kirchhoff(F_E, J_P, snow):
    """tau = dPsi/dF F^T [Pa] (n, 3, 3)."""
    J_P, out = np.broadcast_to(J_P, len(F_E)), np.empty(F_E.shape)

    def fill(rows, law, kind, own):
        h = own.hardening(J_P[rows])
        out[rows] = ELASTICITIES[law].stress(F_E[rows], h * own.mu0, h * own.lam0)

    by_law(len(F_E), snow, fill)
    return out


def return_map(F_trial, J_P, snow):
    """Return F_E and J_P after plastic flow."""
    J_P = np.broadcast_to(J_P, len(F_trial))
    F_E, J_P_new = np.empty(F_trial.shape), np.empty(len(F_trial))

    def fill(rows, law, kind, own):
        flow = OWN_PLASTICITY.get(law) or CLAMPED[kind]
        F_E[rows], J_P_new[rows] = flow(F_trial[rows], J_P[rows], own, ELASTICITIES[law])

    by_law(len(F_trial), snow, fill)
    return F_E, J_P_new


__all__ = ["Snow", "column", "energy", "kirchhoff", "polar_svd", "return_map", "rotation"]
