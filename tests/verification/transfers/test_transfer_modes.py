"""Velocity modes of PolyPIC: what each number of them carries without loss, and energy that never grows."""

from itertools import pairwise

import numpy as np
import pytest
from reference import modes, splines, step
from verification.material import DEFAULT
from verification.stages import Lab

DX = 0.05


def cloud(n=400, seed=11, **more):
    rng = np.random.default_rng(seed)
    return {
        "x": rng.uniform(-0.15, 0.15, (n, 3)),
        "m": rng.uniform(0.01, 0.03, n),
        "V0": np.full(n, 1e-5),
    } | more


def lab_of(core, precision, spline, count, values, transfer="polypic"):
    return Lab(core, precision, spline, transfer, dx=DX, polypic_modes=count, **values)


def around(x, spline):
    ijk, w, _ = splines.stencil(spline, x, DX)
    return ijk, w, ijk - x[:, None, :] / DX


def polynomial(top, degree, seed=12):
    """Return a field (n, 3) -> (n, 3) of up to `top` powers an axis, `degree` in all; |v| ~ 1 m/s."""
    powers = np.array([p for p in np.ndindex(top + 1, top + 1, top + 1) if sum(p) <= degree])
    c = np.random.default_rng(seed).standard_normal((len(powers), 3)) / len(powers)
    return lambda x: np.prod((x[..., None, :] / 0.1) ** powers, axis=-1) @ c


def given(field, x, spline, count):
    """Return v, C and modes of particles at x that carry `field`."""
    ijk, w, z = around(x, spline)
    c = modes.coefficients(w, modes.basis(w, z, count), field(DX * ijk))
    return {"v": c[:, 0], "C": np.swapaxes(c[:, 1:4], 1, 2) / DX, "modes": c[:, 4:]}


@pytest.mark.parametrize(("count", "top", "degree"), [(4, 1, 1), (8, 1, 3), (27, 2, 6)])
def test_polynomials_pass_without_loss(core, precision, eps, spline, count, top, degree):
    """A field in the modes' span goes to the grid and back as it was, even where the cloud ends.

    Every particle brings the field's own values to its nodes, so v_i is the field at x_i, and the projection
    finds the coefficients again. A square's coefficient is a second difference of velocities up to 10 m/s at
    the corners, so each rounding of eps |v| returns 4^3 times; a node sums 100 of them. Measured by what the
    grid feels, sqrt(<s, s>) |c|.
    """
    values = cloud()
    values["x"] = values["x"].astype(precision).astype(float)
    values |= given(polynomial(top, degree), values["x"], spline, count)
    lab = lab_of(core, precision, spline, count, values)
    before = lab.columns()
    lab.step(1e-15)
    after, (_, w, z) = lab.columns(), around(before["x"], spline)
    felt = np.sqrt(modes.norms(w, modes.basis(w, z, count))).astype(float)[:, :, None]
    largest = np.abs(polynomial(top, degree)(DX * around(values["x"], spline)[0])).max()
    for a, b, scale in (
        (after["v"], before["v"], 1.0),
        (DX * after["C"], DX * before["C"], 1.0),
        (after["modes"], before["modes"], felt[:, 4:]),
    ):
        np.testing.assert_allclose(a * scale, b * scale, rtol=0, atol=200 * eps * largest)


@pytest.mark.parametrize(("count", "top", "degree"), [(1, 1, 1), (4, 1, 2), (8, 2, 2)])
def test_what_lies_outside_is_lost(core, precision, spline, count, top, degree):
    """The negative control: a field with one more kind of term comes back changed, by 1e-3 m/s or more.

    A linear field loses C (x_i - x_p) of PIC, z1 z2 is not in APIC's modes, z^2 not in the multilinear ones.
    Each of the ten terms or fewer has a coefficient of 0.1 m/s at 0.1 m, which is 0.025 m/s of z^2 at one
    cell, of which M2 = 1/4 or 1/3 stays in a particle's mean: neighbours differ by 5e-3 m/s.
    """
    values = cloud()
    values |= given(polynomial(top, degree), values["x"], spline, 27)
    values["modes"] = values["modes"][:, : max(count - 4, 0)]
    lab = lab_of(core, precision, spline, count, values)
    before = lab.columns()["v"]
    lab.step(1e-12)
    assert np.abs(lab.columns()["v"] - before).max() > 1e-3


@pytest.mark.parametrize(("count", "transfer"), [(1, "pic"), (4, "apic")])
def test_few_modes_are_pic_and_apic(core, precision, spline, count, transfer):
    """One mode is pic and four are apic, strained snow included: the same bits."""
    rng = np.random.default_rng(13)
    values = cloud(v=rng.standard_normal((400, 3)), C=3 * rng.standard_normal((400, 3, 3)))
    values["F_E"] = np.eye(3) + 0.004 * rng.standard_normal((400, 3, 3))
    ends = []
    for name in ("polypic", transfer):
        lab = lab_of(core, precision, spline, count, values, name)
        for _ in range(5):
            lab.step(1e-4)
        ends.append(lab.columns())
    for name, value in ends[0].items():
        np.testing.assert_array_equal(value, ends[1][name], err_msg=name)


def test_order_of_the_modes():
    """The oracle's order: 1; x, y, z; yz, xz, xy, xyz; then the 19 with a square."""
    powers = modes.exponents(27)
    assert powers[:8] == [
        (0, 0, 0),
        (1, 0, 0),
        (0, 1, 0),
        (0, 0, 1),
        (0, 1, 1),
        (1, 0, 1),
        (1, 1, 0),
        (1, 1, 1),
    ]
    assert all(max(p) == 2 for p in powers[8:])
    assert powers[8:] == sorted(powers[8:])
    assert len(set(powers)) == 27


def random_state(count, transfer, seed=14):
    rng = np.random.default_rng(seed)
    values = cloud(v=rng.standard_normal((400, 3)))
    if transfer != "pic":
        values["C"] = rng.standard_normal((400, 3, 3)) / DX
    if count > 4:
        values["modes"] = rng.standard_normal((400, count - 4, 3))
    return values


METHODS = [("pic", 1), ("apic", 4), ("polypic", 8), ("polypic", 27)]


@pytest.mark.parametrize(("transfer", "count"), METHODS)
def test_energy_never_grows(core, precision, eps, spline, transfer, count):
    """Kinetic energy, that of C and of the modes included, falls with each transfer there and back.

    A node's velocity is a mean of the particles' (|mean|^2 <= mean of squares), and the modes are orthogonal
    under the weights (Bessel's inequality): 1/2 sum m sum_r <s_r, s_r> |c_r|^2 <= 1/2 sum m_i |v_i|^2 <= the
    same of before. Rounding: 100 eps of the energy. dt = 0, so nothing else happens.
    """
    lab = lab_of(core, precision, spline, count, random_state(count, transfer), transfer)
    energies = []
    for _ in range(6):
        t = lab.core.totals(lab.model, lab.state)
        energies.append(t.kinetic + t.affine)
        lab.step(0.0)
    assert energies[1] < 0.9 * energies[0]  # random velocities: most is beyond the grid
    assert all(b <= a * (1 + 100 * eps) for a, b in pairwise(energies))


@pytest.mark.parametrize(("transfer", "count"), [*METHODS, ("flip", 1), ("asflip", 4), ("aflip", 4)])
def test_affine_energy(core, precision, eps, spline, transfer, count):
    """The core's sums are 1/2 sum m |v|^2 and 1/2 sum m sum_r <s_r, s_r> |c_r|^2 of Gram-Schmidt's modes.

    The places within a cell carry eps |x| / dx = 3 eps, which the norms follow with a slope below 10.
    """
    lab = lab_of(core, precision, spline, count, random_state(count, transfer), transfer)
    c = lab.columns()
    p = step.Particles(c["x"], c["v"], c["C"], c["F_E"], np.ones(400), c["m"], c["V0"], DEFAULT, c["modes"])
    kinetic, affine = step.kinetic(p, step.Method(DX, spline, transfer, modes=count))
    t = lab.core.totals(lab.model, lab.state)
    assert t.kinetic == pytest.approx(kinetic, rel=1e-12)
    assert t.affine == pytest.approx(affine, rel=100 * eps, abs=0)
    assert (t.affine > 0) == (transfer not in ("pic", "flip"))


def test_a_state_of_another_model_is_refused(core, precision):
    """A state without the model's modes, or with others, would be read past its end: ValueError."""
    with pytest.raises(ValueError, match="more_modes"):
        core.State(3, -1)
    lab = lab_of(core, precision, "quadratic", 8, cloud())
    core.sort(lab.model, lab.state, lab.grid)
    state = core.State(lab.state.count, 23)
    state.m[:] = 1.0
    with pytest.raises(ValueError, match="modes"):
        core.sort(lab.model, state, core.Grid())
    for stage in (core.p2g, core.g2p):
        with pytest.raises(ValueError, match="modes"):
            stage(lab.model, state, lab.grid, 1e-4)
    with pytest.raises(ValueError, match="modes"):
        core.totals(lab.model, state)


def test_particles_on_the_border_of_a_cell(core, precision, eps):
    """On a cell's border of a quadratic spline one of three weights is 0: polypic goes on, as apic there.

    A lone particle at f = 0 touches nodes 0 and 1 of each axis; node 2 has no mass and no velocity, of which
    a second difference must not be taken. v and C are kept, as by apic, to 20 eps.
    """
    C = np.arange(9.0).reshape(1, 3, 3)
    values = {"x": [[DX * 0.5] * 3], "v": [[1.0, -2.0, 3.0]], "m": [0.02], "V0": [5e-5], "C": C}
    lab = lab_of(core, precision, "quadratic", 27, values)
    lab.step(1e-12)
    end = lab.columns()
    np.testing.assert_allclose(end["v"], values["v"], rtol=0, atol=20 * eps * 3)
    np.testing.assert_allclose(end["C"], C, rtol=0, atol=20 * eps * (3 / DX + 8))
    np.testing.assert_allclose(end["modes"], 0, atol=20 * eps * 3)
