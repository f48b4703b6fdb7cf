"""The core, stage by stage and over several steps, is the oracle: all splines, transfers, solids.

The scene holds everything at once: four snows with different parameters, a stiffness of each particle's
own, strain inside and beyond the yield limits, spin, and eight solids (every shape, every mode, moving and
turning) around a cloud that crosses the origin, so that negative coordinates are half of it.
"""

from dataclasses import replace

import numpy as np
import pytest
from reference import contact, modes, snow, splines, step
from reference.snow import Snow
from verification.stages import Lab

from neve import _core

DX, DT, GRAVITY = 0.05, 2e-4, (0.3, -0.2, -9.81)
LAWS = (
    Snow(),
    Snow(E0=4.8e4, nu=0.3, xi=5.0, theta_c=1.9e-2, theta_s=5e-3),
    Snow(E0=2.8e5, nu=0.1, xi=20.0, theta_c=3.5e-2, theta_s=1e-2),
    Snow(theta_c=0.1, theta_s=0.1, J_P_min=0.98, J_P_max=1.01),
)


def rotation(seed):
    return snow.rotation(np.random.default_rng(seed).standard_normal((1, 3, 3)))[0]


BELTS = {1: (0.3, -0.9, 0.4), 2: (0.8, 0.5, -1.1), 3: (-0.6, 0.0, 0.7)}
"""Velocities of the surfaces of some of the bodies past them [m/s]: a plane and two boxes."""


def bodies():
    """All shapes and modes, at rest and moving, some with belts."""
    return tuple(
        replace(body, belt=np.array(BELTS.get(i, (0, 0, 0)), float)) for i, body in enumerate(solids())
    )


def solids():
    at = np.array
    return (
        contact.Body(
            "plane", "separate", 0.4, (), at([0.01, 0.02, -0.171]), rotation(0) @ np.diag([1, 1, 1])
        ),
        contact.Body(
            "plane", "slip", 0.3, (), at([-0.193, 0, 0]), turn_z_to([1, 0.1, 0.05]), at([0.1, 0, 0.2])
        ),
        contact.Body(
            "box", "separate", 0.2, (0.11, 0.13, 0.09), at([0.1, 0.12, 0.03]), rotation(1), at([-1.0, 0.2, 0])
        ),
        contact.Body(
            "box", "sticky", 0.0, (0.07, 0.13, 0.17), at([-0.1, 0.13, 0.05]), rotation(2), at([0, 0, 1.0])
        ),
        contact.Body(
            "sphere",
            "separate",
            0.7,
            (0.083,),
            at([0.12, -0.11, -0.1]),
            np.eye(3),
            at([0, 1.0, 0]),
            at([9.0, 0, 3]),
        ),
        contact.Body(
            "sphere",
            "slip",
            0.1,
            (0.061,),
            at([-0.11, -0.13, 0.11]),
            rotation(3),
            at([0, 0, 0]),
            at([0, 9.0, 3]),
        ),
        contact.Body(
            "cylinder", "slip", 0.5, (0.051, 0.17), at([0.02, 0.01, 0.12]), rotation(4), at([0.5, 0, -1.0])
        ),
        contact.Body(
            "cylinder",
            "sticky",
            0.5,
            (0.043, 0.11),
            at([0.01, -0.15, 0.01]),
            rotation(5),
            at([0, 0, 0]),
            at([0, 0, 20.0]),
        ),
    )


def turn_z_to(n):
    z = np.asarray(n, float) / np.linalg.norm(n)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def cloud(n=900, seed=7):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.2, 0.2, (n, 3))
    return {
        "x": x,
        "v": np.cross([4.0, -3.0, 6.0], x) + 0.3 * rng.standard_normal((n, 3)) + [0.5, 0, -1],
        "C": 4 * rng.standard_normal((n, 3, 3)),
        "F_E": np.eye(3) + 0.006 * rng.standard_normal((n, 3, 3)),
        "J_P": rng.uniform(0.93, 1.02, n),
        "m": rng.uniform(0.01, 0.03, n),
        "V0": rng.uniform(3e-5, 7e-5, n),
        "stiffness": rng.uniform(0.5, 2.0, n),
        "material": rng.integers(0, len(LAWS), n),
    }


def particles(values):
    law = Snow.table(LAWS, values["material"], stiffness=values["stiffness"])
    names = ("x", "v", "C", "F_E", "J_P", "m", "V0")
    return step.Particles(*(np.array(values[name], float) for name in names), law=law)


def both(core, precision, spline, transfer, around=(), count=8, n=900):
    values = cloud(n)
    if transfer == "polypic" and count > 4:
        values["modes"] = 0.4 * np.random.default_rng(8).standard_normal((n, count - 4, 3))
    lab = Lab(
        core, precision, spline, transfer, laws=LAWS, dx=DX, gravity=GRAVITY, polypic_modes=count, **values
    )
    for body in around:
        lab.add_body(body)
    rounded = {
        name: np.asarray(a).astype(precision).astype(float)
        for name, a in values.items()
        if name != "material"
    }
    method = step.Method(DX, spline, transfer, 0.95, GRAVITY, modes=count)
    p = particles(values | rounded)
    p.more = rounded.get("modes")
    return lab, p, method


def agree(lab, p, method, tolerance, scales):
    got = lab.columns()
    names = ("x", "v", "F_E", "J_P") + (("C",) if method.affine else ())
    errors = {name: np.abs(got[name] - getattr(p, name)).max() / scales[name] for name in names}
    if method.count > 4:
        # by what the grid feels of a mode: a square's coefficient is 0/0 where no node does
        ijk, w, _ = splines.stencil(method.spline, p.x, DX)
        s = modes.basis(w, ijk - p.x[:, None, :] / DX, method.count)
        felt = np.sqrt(modes.norms(w, s))[:, 4:, None] * (got["modes"][:, : method.count - 4] - p.more)
        errors["modes"] = np.abs(felt).max() / scales["v"]
    if lab.model.has_play:
        errors["lift"] = np.abs(got["modes"][:, -1] - p.lift).max() / scales["x"]
        assert np.abs(p.lift).max() > 0
    assert {name: error for name, error in errors.items() if error > tolerance} == {}


SCALES = {"x": 0.2, "v": 3.0, "F_E": 1.0, "J_P": 1.0, "C": 3.0 / DX}


def test_nodes(spline, transfer):
    """Mass and momentum after P2G, and velocities after the grid update, node by node: 1e-12 in float64.

    A node with a mass below 1e-9 of the largest is left out of the velocities: its momentum is a sum of
    terms that cancel to fewer digits than its mass, and so says nothing.
    """
    lab, p, method = both(_core.f64, "float64", spline, transfer, bodies())
    lab.p2g(DT)
    ijk, mass, momentum = lab.grid.nodes()
    lab.grid_update(DT)
    _, _, v = lab.grid.nodes()
    nodes = step.step(p, method, DT, bodies())
    at = tuple((ijk - nodes.low).T)
    assert (nodes.mass > 0).sum() == len(mass)
    np.testing.assert_allclose(mass, nodes.mass[at], rtol=0, atol=1e-13 * mass.max())
    if transfer == "flip":
        mv = nodes.mass[at][:, None] * nodes.v[at]
        np.testing.assert_allclose(momentum, mv, rtol=0, atol=1e-12 * np.abs(momentum).max())
    heavy = mass > 1e-9 * mass.max()
    np.testing.assert_allclose(v[heavy], nodes.v_new[at][heavy], rtol=0, atol=1e-8)
    heavy = mass > 1e-3 * mass.max()
    np.testing.assert_allclose(v[heavy], nodes.v_new[at][heavy], rtol=0, atol=1e-11)


@pytest.mark.parametrize("around", [(), bodies()], ids=["free", "solids"])
def test_steps(spline, transfer, around):
    """Ten steps, or four with eight solids, with plastic flow: 1e-12 of each quantity's size in float64.

    A step rounds by 60 eps = 1.3e-14, LAPACK's share in the oracle. Errors travel as waves, which this dt
    resolves (the stiffest needs 13 steps for a cell), so they add up rather than multiply: 10 steps, and 7
    to spare.
    """
    lab, p, method = both(_core.f64, "float64", spline, transfer, around)
    J_P = p.J_P.copy()
    for _ in range(4 if around else 10):  # the oracle's solids take their time
        lab.step(DT)
        step.step(p, method, DT, around)
    assert (np.abs(p.J_P / J_P - 1) > 1e-3).mean() > 0.1  # it did flow
    agree(lab, p, method, 1e-12, SCALES)


@pytest.mark.parametrize("count", [1, 4, 27])
def test_modes(spline, count):
    """Two steps of polypic with other numbers of modes: 1e-12; eight are in the tests above."""
    lab, p, method = both(_core.f64, "float64", spline, "polypic", bodies(), count=count, n=300)
    for _ in range(2):
        lab.step(DT)
        step.step(p, method, DT, bodies())
    agree(lab, p, method, 1e-12, SCALES)


def test_modes_in_single_precision(spline):
    """One step with 27 modes in float32: 1e-5, as below."""
    lab, p, method = both(_core.f32, "float32", spline, "polypic", count=27, n=300)
    lab.step(DT)
    step.step(p, method, DT)
    agree(lab, p, method, 1e-5, SCALES)


def test_every_solid_is_touched():
    """The scene above means something only if each solid holds some of the cloud, and none holds it all."""
    x = cloud()["x"]
    for body in bodies():
        inside = body.distance(x)[0] <= 0
        assert 5 < inside.sum() < 800, (body.shape, body.mode, inside.sum())


def test_single_precision(spline, transfer):
    """One step in float32: 1e-5 of each quantity's size.

    Positions carry eps |x| / 2, weights 20 eps, velocities and F_E a few eps; J_P sums three stretches; the
    nodes' force f/m is V0 tau grad w / m, whose error, 30 eps M_c h dt / (rho dx) = 1e-4 m/s x 30 eps ...
    is far below. 30 eps = 4e-6 in all; solids are left out, where a point may fall on the other side of a
    surface.
    """
    lab, p, method = both(_core.f32, "float32", spline, transfer)
    lab.step(DT)
    step.step(p, method, DT)
    agree(lab, p, method, 1e-5, SCALES)


def test_volume_from_the_grid(spline):
    """V0 = m / rho of the grid, after P2G of the first step: 1e-12."""
    lab, p, method = both(_core.f64, "float64", spline, "apic")
    lab.p2g(DT)
    _core.f64.volumes_from_grid(lab.model, lab.state, lab.grid)
    ijk, w, _ = splines.stencil(spline, p.x, DX)
    nodes = step.rasterize(p, method, ijk, w, modes.basis(w, ijk - p.x[:, None, :] / DX, method.count))
    at = tuple(np.moveaxis(ijk - nodes.low, -1, 0))
    np.testing.assert_allclose(lab.columns()["V0"], step.volumes(p, method, nodes, at, w), rtol=1e-12)
