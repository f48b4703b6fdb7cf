"""The longest stable step: the bound on every frequency, where it is reached, and that no step is longer."""

import logging

import numpy as np
import pytest
from reference import splines
from reference.snow import Snow
from verification.scenes import ball, scene, simulate
from verification.stages import Lab

from neve import _core
from neve.mpm.model import stable_courant

DX, E0, NU, RHO = 0.1, 1e5, 0.3, 300.0
MU, LAM = E0 / (2 * (1 + NU)), E0 * NU / ((1 + NU) * (1 - 2 * NU))
C_P = np.sqrt((LAM + 2 * MU) / RHO)
MLS = ("apic", "polypic", "asflip")


def stiffness(spline, transfer):
    return _core.f64.Model(DX, spline, transfer, 1.0, np.zeros(3)).stencil_stiffness


def strain_maps(spline, transfer, x):
    """Node numbers, weights (n, K) and what turns nodes' velocities into grad v, (n, K, 3) [1/m]."""
    ijk, w, grad_w = splines.stencil(spline, x, DX)
    if transfer in MLS:
        grad_w = w[..., None] * (ijk * DX - x[:, None, :]) / (splines.MOMENT[spline] * DX**2)
    return ijk, w, grad_w


def largest_frequency(spline, transfer, x, m, V0):
    """w of the stiffest vibration of elastic particles at rest [1/s], from the nodes' K and M by LAPACK."""
    ijk, w, g = strain_maps(spline, transfer, x)
    used = w > 1e-12
    nodes, place = np.unique(ijk[used], axis=0, return_inverse=True)
    index = np.full(w.shape, -1)
    index[used] = place
    mass, K = np.zeros(len(nodes)), np.zeros((3 * len(nodes),) * 2)
    for p in range(len(x)):
        rows = index[p][used[p]]
        np.add.at(mass, rows, m[p] * w[p][used[p]])
        a = g[p][used[p]]
        # L = sum v_i g_i^T;  L : A : L = lam tr^2 + mu |L + L^T|^2 / 2
        block = LAM * np.einsum("ia,jb->iajb", a, a)
        block += MU * (np.einsum("ik,jk,ab->iajb", a, a, np.eye(3)) + np.einsum("ib,ja->iajb", a, a))
        dofs = (3 * rows[:, None] + np.arange(3)).ravel()
        K[np.ix_(dofs, dofs)] += V0[p] * block.reshape(len(dofs), -1)
    scale = np.repeat(mass, 3) ** -0.5
    return np.sqrt(np.linalg.eigvalsh(scale[:, None] * K * scale)[-1])


@pytest.mark.parametrize("transfer", ["flip", "apic"])
def test_no_vibration_is_faster_than_the_stiffest_particle_alone(spline, transfer):
    """w^2 <= stiffness (1 + nu) / (1 - nu) max V0 M_c / (m dx^2), for coincident and light particles too.

    K and M are sums over particles, so that their Rayleigh quotient is at most the largest of a particle with
    its own share of the nodes' masses. Alone the bound is reached, by MLS anywhere to rounding.
    """
    rng = np.random.default_rng(3)
    lone = np.array([[0.31, 0.57, 0.12]]) * DX
    clouds = {
        "alone": lone,
        "coincident": np.repeat(lone, 5, axis=0),
        "pair": lone + np.array([[0, 0, 0], [0.2, 0.1, 0.4]]) * DX,
        "layer": rng.uniform(0, 3, (12, 3)) * np.array([1, 1, 0.02]) * DX,
        "lump": rng.uniform(0, 2, (20, 3)) * DX,
    }
    for name, x in clouds.items():
        m, V0 = 10.0 ** rng.uniform(-2, 1, (2, len(x)))
        bound2 = stiffness(spline, transfer) * (1 + NU) / (1 - NU) * (LAM + 2 * MU) * (V0 / m).max() / DX**2
        share = largest_frequency(spline, transfer, x, m, V0) ** 2 / bound2
        assert share <= 1 + 1e-12, name
        if name == "alone":
            assert share > (0.4 if transfer == "flip" else 1 - 1e-9)


def test_the_sharpest_place_of_a_cell(spline):
    """The stiffness of gradients is the largest sum w'^2 / w along an axis: on a fine raster, to 1e-3."""
    f = np.linspace(0, 1, 20001)[1:-1] * DX
    x = np.stack([f, np.full_like(f, 0.3 * DX), np.full_like(f, 0.3 * DX)], axis=1)
    _, w, g = splines.stencil(spline, x, DX)
    sharpness = (g[..., 0] ** 2 / np.where(w > 0, w, np.inf)).sum(1).max() * DX**2
    assert stiffness(spline, "flip") == pytest.approx(sharpness, rel=1e-3)
    assert stiffness(spline, "flip") >= sharpness


def vibrate(transfer, spline, courant, steps):
    """Let a particle that is strained by 1e-6 on all axes go; return ln det F_E / 3e-6 after each step."""
    law = Snow(law="hencky", plasticity="none", E0=E0, nu=NU, rho0=RHO)
    lab = Lab(
        _core.f64,
        "float64",
        spline,
        transfer,
        laws=(law,),
        dx=DX,
        alpha=1.0,
        x=[[0.31, 0.57, 0.12]],
        m=[RHO * 1e-4],
        V0=[1e-4],
        F_E=[np.exp(1e-6) * np.eye(3)],
        J_P=[1.0],
        stiffness=[1.0],
        strength=[1.0],
    )
    out = [1.0]
    for _ in range(steps):
        lab.step(courant * DX / C_P)
        out.append(np.log(np.linalg.det(np.array(lab.state.F_E[0]))) / 3e-6)
    return np.array(out)


@pytest.mark.parametrize("transfer", ["apic", "polypic"])
def test_a_lone_particle_keeps_its_vibration(transfer, spline):
    """e_n+1 = (2 - h^2) e_n - e_n-1, h^2 = 2 at the longest stable step: 1, -1, -1, 1, 1, ... for ever.

    The first step starts at rest: e_1 = (1 - h^2) e_0. Strains of 1e-6 leave 1e-5 in thirty steps.
    """
    e = vibrate(transfer, spline, stable_courant(stiffness(spline, transfer), NU), 30)
    expected = [1.0, -1.0]
    while len(expected) < len(e):
        expected.append(-expected[-2])
    np.testing.assert_allclose(e, expected, atol=1e-4)


def test_what_forgets_its_velocity_gradient_is_at_its_limit(spline):
    """pic keeps no gradient: e_n+1 = (1 - h^2) e_n, stable up to h^2 = 2 and not beyond.

    h^2 = 2 where the particle is at the sharpest place on all axes; elsewhere it decays at the longest
    stable step, and grows at 1.3 times that.
    """
    longest = stable_courant(stiffness(spline, "pic"), NU)
    decays, grows = (np.abs(vibrate("pic", spline, q * longest, 10)) for q in (1.0, 1.3))
    assert (np.diff(decays) < 0).all()
    assert decays[-1] < 0.95
    assert (np.diff(grows) > 0).all()


def test_a_step_of_the_scene_is_shortened_to_a_stable_one(caplog):
    """numerics.dt of 0.05 s, far beyond what waves allow: courant dx / c instead, told once; energy falls."""
    snow = {"law": "hencky", "plasticity": "none", "E0": E0, "nu": NU, "rho0": RHO}
    sim = simulate(
        scene([ball(radius=0.2, velocity=(0, 0, 1.0))], snow=snow, dx=DX, dt=0.05, initial_volume="sampled")
    )
    sim.state.v[::2] *= -1.0
    before = sim.diagnostics()
    longest = stable_courant(stiffness("quadratic", "apic"), NU) * DX / C_P
    with caplog.at_level(logging.WARNING, logger="neve"):
        sim.advance(0.05)
        sim.advance(0.05)
    assert 0.7 * longest < sim.stats.dt_mean < longest * (1 + 1e-3)
    (record,) = caplog.records
    assert "numerics.dt = 0.05 s is beyond the limit" in record.getMessage()
    after = sim.diagnostics()
    assert after.kinetic + after.affine + after.elastic < before.kinetic


def test_high_poisson_ratios_shorten_the_automatic_step():
    """pic at nu = 0.49: courant = sqrt(2 / 6 / 2.92) = 0.338 is less than cfl = 0.6; at nu = 0.2 0.471."""
    for nu, courant in ((0.49, 0.338), (0.2, 0.471)):
        snow = {"law": "hencky", "plasticity": "none", "E0": E0, "nu": nu, "rho0": RHO}
        sim = simulate(
            scene([ball()], snow=snow, dx=DX, dt="auto", cfl=0.6, transfer="pic", initial_volume="sampled")
        )
        mu, lam = E0 / (2 * (1 + nu)), E0 * nu / ((1 + nu) * (1 - 2 * nu))
        longest = courant * DX / np.sqrt((lam + 2 * mu) / RHO)
        sim.advance(10.5 * longest)
        assert sim.steps == 11
        assert sim.stats.bound == "wave"
