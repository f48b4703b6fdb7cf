"""The zero-energy (hourglass) mode of pressed snow: no solve sees it, so it bounds the step."""

import numpy as np
import pytest
from verification.sph.common import SNOW, block, kernel, prepare, smoothed, solve, world

from neve.sph.constants import SWING
from neve.validate.scenes import box, duct, moduli, plane


def plane_stiffness():
    """8 d^5 sum d2W/dz2 over the nine particles of the next plane of a lattice, by differences."""
    d, e = 1.0, 1e-4
    across = np.array([(i * d, j * d, d) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    slopes = [kernel(across + np.array((0.0, 0.0, way)), 2 * d)[1][:, 2].sum() for way in (-e, e)]
    return 8.0 * (slopes[1] - slopes[0]) / (2 * e)


@pytest.mark.parametrize("stretches", [(0.98, 0.98, 0.98), (1.0, 1.0, 0.98)])
def test_their_frequency(stretches):
    """A lattice under pressure, every other plane displaced: pushed back by omega^2 of the displacement.

    omega^2 = 8 sigma V sum d2W/dz2 / rho, V = d^3: the lattice's own sum of kernels is 1 to 0.1 %, its moment
    to 2 %.
    """
    spacing, shift = 0.05, 1e-4
    snow, model = block((9, 9, 9), spacing), world()
    prepare(snow, model)  # densities at birth are those without strain
    snow.F_E[...] = np.diag(stretches)
    layer = np.rint(np.asarray(snow.x)[:, 2] / spacing).astype(int)
    snow.x[:, 2] += shift * spacing * (1.0 - 2.0 * (layer % 2))
    prepare(snow, model)
    solve(snow, model, 1e-7)
    middle = np.abs(np.asarray(snow.x) - 4 * spacing).max(axis=1) < 0.5 * spacing  # on an even plane
    found = (np.asarray(snow.pressed) + np.asarray(snow.sheared))[middle, 2] / (shift * spacing)
    G0, lam0, _ = moduli(SNOW["E0"], SNOW["nu"])
    J = np.prod(stretches)
    hard = np.exp(SNOW["xi"] * (1.0 - 1.0 / J))  # rho stands, so that rho_0 = J rho
    shear = 2.0 * G0 * (1.0 - np.array(stretches))
    deviator = (shear[2] - shear.mean()) * np.asarray(snow.L)[middle, 2, 2]  # L: of the lattice's moment
    sigma = hard * (lam0 * (1.0 / J - 1.0) + shear.mean() + deviator)
    rho = np.asarray(snow.rho)[middle]
    assert -found == pytest.approx(plane_stiffness() * sigma / rho / spacing**2, rel=5e-3)
    least = np.asarray(snow.rho).min()  # at a corner, where neighbours are missing
    assert 0.999 * np.sqrt(-found) < snow.stress_rate() < 1.1 * np.sqrt(-found * rho / least)


def test_snow_without_pressure_and_water_have_none():
    """Snow that is stretched all around, or as it was born; a pond, however deep."""
    snow, model = block((4, 4, 4)), world()
    prepare(snow, model)
    assert snow.stress_rate() < 1e-3
    snow.F_E[...] = np.diag((1.002, 1.004, 1.003))
    prepare(snow, model)
    assert snow.stress_rate() == 0.0
    pond = smoothed(
        [box((0, 0, 0), (0.2, 0.2, 0.4)) | {"phase": "water"}],
        [*duct(0.2, 0.2), plane((0, 0, 0), (0, 0, 1), mu_c=0.0)],
        (0.0, 0.0, -9.81),
        sampling="regular",
    )
    pond.advance(0.05)
    assert np.asarray(pond.state.p).max() > 1e3
    assert pond.state.stress_rate() == 0.0


def squeezed(height=0.4, rate=0.5, layers=16):
    """Squeeze a column of elastic snow by a twentieth: nothing flows, nothing hardens.

    Returns how far its middle planes are from the middle of their neighbours, root mean square, in spacings.
    """
    sim = smoothed(
        [box((0, 0, 0), (0.2, 0.2, height))],
        [
            *duct(0.2, 0.2),
            plane((0, 0, 0), (0, 0, 1)),
            plane((0, 0, height), (0, 0, -1), velocity=[0.0, 0.0, -rate * height]),
        ],
        snow={"plasticity": "none"},
        sampling="regular",
        precision="float32",
        dx=height / layers,
    )

    def heights():
        return np.asarray(sim.state.x)[np.argsort(np.asarray(sim.state.id)), 2] * layers / height

    layer = np.rint(heights() - 0.5)
    sim.state.v[:, 2] = -rate * np.asarray(sim.state.x)[:, 2]
    sim.advance(0.05 / rate)
    z = np.array([heights()[layer == k].mean() for k in range(layers)])
    off = z[1:-1] - 0.5 * (z[:-2] + z[2:])
    return float(np.sqrt(np.mean(off[3:-3] ** 2)))


def test_steps_above_two_over_omega_let_them_grow(monkeypatch):
    """In steps of 10 ms planes of elastic snow alternate, in those that are bound they do not.

    So it is not the flow. Of a leapfrog, which x += dt v(x) is, omega dt = 2 is the limit.
    """
    assert SWING < 2.0
    assert squeezed() < 5e-3
    monkeypatch.setattr("neve.sph.solver.SWING", np.inf)
    assert squeezed() > 0.03
