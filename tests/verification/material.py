"""The laws of the core at single points: parameters, matrices, and the call."""

from dataclasses import fields

import numpy as np
from reference.snow import Snow, rotation

DEFAULT = Snow()
ELASTIC = Snow(theta_c=0.9, theta_s=9.0)  # nothing yields
LAPACK = 60 * np.finfo(float).eps  # how far the oracle's own SVD is from exact, measured: 40 eps at the worst


def parameters(law):
    """The constants of an oracle's snow, by name, as the core takes them."""
    words = ("law", "plasticity", "strength")
    return {field.name: float(getattr(law, field.name)) for field in fields(law) if field.name not in words}


def respond(core, F_trial, J_P, law, precision="float64"):
    """Return F_E, J_P, tau, psi of the core after one return map, as float64 arrays."""
    return response(core, F_trial, J_P, law, precision)[:4]


def response(core, F_trial, J_P, law, precision="float64"):
    """Return F_E, J_P, tau, psi and the acoustic modulus of the core after one return map, as float64."""
    F = np.ascontiguousarray(F_trial, dtype=precision)
    J, strength = (
        np.broadcast_to(np.asarray(a, dtype=precision), len(F)).copy() for a in (J_P, law.strength)
    )
    out = core.law(str(law.law), str(law.plasticity), parameters(law), F, J, strength)
    return tuple(np.asarray(part, dtype=float) for part in out)


def near_identity(n, spread, seed=0):
    return np.eye(3) + spread * np.random.default_rng(seed).standard_normal((n, 3, 3))


def turns(n, seed=0):
    """Random rotation matrices (n, 3, 3)."""
    return rotation(np.random.default_rng(seed).standard_normal((n, 3, 3)))


def transpose(A):
    return np.swapaxes(A, -1, -2)
