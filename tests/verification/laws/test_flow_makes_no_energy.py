"""What flows dissipates: where theory promises that a return map leaves no more energy than it gets."""

from itertools import pairwise

import numpy as np
import pytest
from reference import snow
from reference.laws import LAWS
from verification.material import near_identity, respond

from neve import _core

DEEP = 10.0 ** np.linspace(-4, -0.9, 4000)


@pytest.mark.parametrize("name", ["cam_clay", "cam_clay cohesive", "drucker_prager"])
def test_projection_loses_energy(name):
    """Psi(F_E) <= Psi(F_trial) for strains from 1e-4 to 0.13, and less wherever something flowed.

    The closest point of a convex set that holds 0, in the norm whose square is the energy, is nearer to 0
    (cam_clay: the ellipse holds p = 0); a shorter deviator at the same volume has less energy, and snow torn
    at an apex without cohesion keeps none (drucker_prager). 1e-13: rounding of two energies whose strains
    carry 60 eps each of M_c eps^2, relative to the strain 1e-4: 2 x 60 eps / 1e-4 ~ 3e-10 of Psi.
    """
    law = LAWS[name]
    F = np.eye(3) + DEEP[:, None, None] * np.random.default_rng(5).standard_normal((len(DEEP), 3, 3))
    F = F[np.linalg.det(F) > 0.3]
    F_E, _, _, psi = respond(_core.f64, F, 1.0, law)
    before = snow.energy(F, np.ones(len(F)), law)
    assert (psi <= before * (1 + 3e-10)).all()
    flowed = np.abs(F_E - F).max((1, 2)) > 1e-3 * np.abs(F - np.eye(3)).max((1, 2))
    assert flowed.mean() > 0.5
    assert (psi < before * (1 - 1e-7))[flowed].all()


def test_cohesive_grains_shear_at_a_loss():
    """drucker_prager with cohesion: below the apex the deviator shrinks at constant volume, so Psi falls."""
    law = LAWS["drucker_prager cohesive"]
    F = near_identity(2000, 0.02, seed=6)
    _, J_P, _, psi = respond(_core.f64, F, 1.0, law)
    below = J_P == 1.0
    assert 0.2 < below.mean() < 0.9
    before = snow.energy(F, np.ones(len(F)), law)
    assert (psi <= before * (1 + 1e-9))[below].all()


@pytest.mark.parametrize("name", ["drucker_prager", "drucker_prager cohesive"])
def test_tearing_and_closing_gives_nothing_back(name):
    """Work along a closed path of volume: torn to J = 1.1, closed, pressed to 0.97, let go.

    The stress is a function of the volume alone there, p = -K min(e, e_c), so the exact work of a closed
    path is zero. The trapezoidal rule misses K de^2 / 2 with de = 1e-4 at each of four kinks: 1e-6 K is
    ample.
    """
    law = LAWS[name]
    e = np.interp(np.linspace(0, 4, 4001), [0, 1, 2, 3, 4], np.log([1, 1.1, 1, 0.97, 1]))
    F_E, J_P, work, p_before = np.eye(3)[None], np.ones(1), 0.0, 0.0
    for before, after in pairwise(e):
        F_E, J_P, tau, _ = respond(_core.f64, np.exp((after - before) / 3) * F_E, J_P, law)
        p = -np.trace(tau[0]) / 3
        work -= 0.5 * (p + p_before) * (after - before)
        p_before = p
    assert work == pytest.approx(0, abs=1e-6 * law.K)
    assert J_P[0] == pytest.approx(1, abs=1e-12)
