"""The snow law of the core at single points: parameters, matrices, and the call."""

from dataclasses import fields

import numpy as np
from reference.snow import Snow, rotation

DEFAULT = Snow()
ELASTIC = Snow(theta_c=0.9, theta_s=9.0)  # nothing yields
LAPACK = 60 * np.finfo(float).eps  # how far the oracle's own SVD is from exact, measured: 40 eps at the worst


def parameters(law):
    return {field.name: float(getattr(law, field.name)) for field in fields(law)}


def respond(core, F_trial, J_P, law, precision="float64"):
    """Return F_E, J_P, tau, psi of the core after one return map, as float64 arrays."""
    F = np.ascontiguousarray(F_trial, dtype=precision)
    J = np.broadcast_to(np.asarray(J_P, dtype=precision), len(F)).copy()
    out = core.stomakhin2013(F, J, parameters(law))
    return tuple(np.asarray(part, dtype=float) for part in out)


def near_identity(n, spread, seed=0):
    return np.eye(3) + spread * np.random.default_rng(seed).standard_normal((n, 3, 3))


def turns(n, seed=0):
    """Random rotation matrices (n, 3, 3)."""
    return rotation(np.random.default_rng(seed).standard_normal((n, 3, 3)))


def transpose(A):
    return np.swapaxes(A, -1, -2)
