"""What flows dissipates: where theory promises that a return map leaves no more energy than it gets."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from reference import snow
from reference.laws import CLAMPED, LAWS
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


LIMITS = {
    "default": (2.5e-2, 7.5e-3),
    "powdery": (1e-3, 2e-4),
    "tears first": (0.1, 1e-3),
    "crushed first": (1e-3, 0.04),
}


@pytest.mark.parametrize("nu", [0.2, 0.45, 0.49, 0.499])
@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("name", CLAMPED)
def test_clamped_snow_makes_no_energy_within_its_limits(name, limits, nu):
    """Without hardening: all stretches end within their limits, and Psi does not grow.

    Where the clamp of Stomakhin et al. 2013 dissipates, sum_k dPsi/ds_k (s'_k - s_k) >= 0 with the stress of
    the clamped state, the state is that one. Psi is not convex in the stretches: strains of 5 % in one step
    can then raise it by up to a fifth, at nu = 0.499, where a clamped pressed axis swells snow.
    """
    theta_c, theta_s = LIMITS[limits]
    law = replace(LAWS[name], nu=nu, theta_c=theta_c, theta_s=theta_s, xi=0.0)
    stretch = 1 + 0.05 * np.random.default_rng(7).standard_normal((3000, 3))
    F = stretch[:, :, None] * np.eye(3)
    F_E, J_P, _, psi = respond(_core.f64, F, 1.0, law)
    s = np.diagonal(F_E, axis1=1, axis2=2)
    assert s.min() >= 1 - theta_c - 1e-12
    assert s.max() <= 1 + theta_s + 1e-12
    np.testing.assert_allclose(s.prod(1) * J_P, stretch.prod(1), rtol=1e-12)
    clamped = np.clip(stretch, 1 - theta_c, 1 + theta_s)
    sound = dissipation(stretch, clamped, law) > 0
    grows = psi / snow.energy(F, np.ones(len(F)), law)
    assert grows[~sound].max() <= 1 + 1e-9
    assert grows.max() <= (1 + 1e-9 if nu < 0.48 else 1.2)
    np.testing.assert_allclose(s[sound], clamped[sound], rtol=0, atol=1e-12)
    assert not sound.all()


@pytest.mark.parametrize("nu", [0.2, 0.45, 0.49, 0.499])
@pytest.mark.parametrize("limits", LIMITS)
@pytest.mark.parametrize("name", CLAMPED)
def test_clamped_snow_dissipates_in_small_steps(name, limits, nu):
    """From states within the limits, by strains of 5e-5, less than theta_s: flow never does work."""
    theta_c, theta_s = LIMITS[limits]
    law = replace(LAWS[name], nu=nu, theta_c=theta_c, theta_s=theta_s, xi=0.0)
    rng = np.random.default_rng(8)
    start = np.clip(1 + rng.normal(0, max(theta_c, theta_s), (3000, 3)), 1 - theta_c, 1 + theta_s)
    trial = start * (1 + 5e-5 * rng.standard_normal((3000, 3)).clip(-3, 3))
    F_E = respond(_core.f64, trial[:, :, None] * np.eye(3), 1.0, law)[0]
    s = np.diagonal(F_E, axis1=1, axis2=2)
    assert dissipation(trial, s, law).min() >= -1e-12 * law.M_c


def dissipation(before, after, law):
    """sum_k dPsi/ds_k (s'_k - s_k), the stress that of the stretches after the flow (n,) [Pa]."""
    tau = snow.kirchhoff(after[:, :, None] * np.eye(3), np.ones(len(after)), law)
    return (np.diagonal(tau, axis1=1, axis2=2) / after * (before - after)).sum(1)


def test_the_clamp_alone_makes_energy():
    """What the test above guards against is there: pressed on two axes and stretched on the third."""
    law = replace(LAWS["stomakhin2013"], xi=0.0, nu=0.45)
    trial, clamped = (np.diag(s)[None] for s in ([0.975, 0.975, 1.01], [0.975, 0.975, 1.0075]))
    one = np.ones(1)
    assert snow.energy(clamped, one, law) > snow.energy(trial, one, law)
    F_E, J_P, _, psi = respond(_core.f64, trial, 1.0, law)
    assert psi < snow.energy(trial, one, law)
    np.testing.assert_allclose(np.diag(F_E[0])[2], 1.0075, rtol=1e-12)  # within its limits all the same
    np.testing.assert_allclose(J_P, 1, rtol=1e-12)  # the rest of the way keeps the volume


@pytest.mark.parametrize("name", CLAMPED)
def test_no_walk_through_strains_yields_work(name):
    """Work put in along a random walk of strains, 3000 small steps, is at least what is stored at its end.

    Steps of 1e-4 in each direction of a frame that turns at random: the stress of the start of a step is off
    by M_c 1e-4, the work of the walk by 3000 M_c 1e-8 / 2 times the nine directions. The walk dissipates a
    hundred times that. One axis is pressed all the time, so that it presses on the others at their limits.
    """
    law = replace(LAWS[name], nu=0.4, xi=0.0)
    rng = np.random.default_rng(11)
    step, count, paths = 1e-4, 3000, 20
    F_E, J_P, work = np.tile(np.diag([0.99, 1, 1.0]), (paths, 1, 1)), np.ones(paths), np.zeros(paths)
    tau = respond(_core.f64, F_E, J_P, law)[2]
    start = snow.energy(F_E, J_P, law)
    for _ in range(count):
        grad_v = step * rng.choice([-1.0, 1.0], (paths, 3, 3)) + np.diag([-step, step, step])
        work += (tau * grad_v).sum((1, 2))
        F_E, J_P, tau, psi = respond(_core.f64, F_E + grad_v @ F_E, J_P, law)
    off = count * 9 * law.M_c * step**2
    assert (work - (psi - start) >= -off).all()
