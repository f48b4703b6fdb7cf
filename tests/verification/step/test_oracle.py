"""The oracle itself against analytic answers, before anything is held against it."""

import numpy as np
import pytest
from reference import contact, snow, splines, step
from reference.snow import Snow

COMBINATIONS = [(s, t) for s in ("quadratic", "cubic") for t in ("pic", "flip", "apic", "polypic", "asflip")]
ELASTIC = Snow(theta_c=0.9, theta_s=9.0)


def some_matrices(n, spread, seed=0):
    return np.eye(3) + spread * np.random.default_rng(seed).standard_normal((n, 3, 3))


def ball(spline, transfer, gravity=(0.0, 0.0, 0.0), law=ELASTIC, seed=1):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.12, 0.12, (300, 3))
    method = step.Method(dx=0.05, spline=spline, transfer=transfer, gravity=gravity)
    return step.Particles.at_rest(x, m=0.02, V0=5e-5, law=law), method


@pytest.mark.parametrize("spline", ["quadratic", "cubic"])
def test_spline_moments(spline):
    """Sum w = 1, sum w x_i = x, sum grad w = 0, sum x_i (x) grad w = I, D = dx^2/4 or dx^2/3.

    Splines of degree k reproduce polynomials up to degree 1 exactly; K <= 64 terms of size <= |x|/dx
    leave 1e-13.
    """
    dx, x = 0.1, np.random.default_rng(0).uniform(-1, 1, (500, 3))
    ijk, w, grad_w = splines.stencil(spline, x, dx)
    r = dx * ijk - x[:, None, :]
    D = np.einsum("pk,pka,pkb->pab", w, r, r)
    np.testing.assert_allclose(w.sum(1), 1, atol=1e-13)
    np.testing.assert_allclose(np.einsum("pk,pka->pa", w, dx * ijk), x, atol=1e-13)
    np.testing.assert_allclose(grad_w.sum(1), 0, atol=1e-11)
    identity = np.broadcast_to(np.eye(3), D.shape)
    np.testing.assert_allclose(np.einsum("pka,pkb->pab", dx * ijk, grad_w), identity, atol=1e-11)
    np.testing.assert_allclose(D, splines.MOMENT[spline] * dx**2 * identity, atol=1e-15)


def test_stress_is_the_derivative_of_energy():
    """tau = (dPsi/dF) F^T; central differences, error h^2 Psi'''/6 + eps Psi/h < 1e-8 M_c at h = 1e-5."""
    F, J_P, h = some_matrices(20, 0.1), np.linspace(0.9, 1.1, 20), 1e-5
    P = np.empty_like(F)
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = h
            P[:, i, j] = (snow.energy(F + d, J_P, ELASTIC) - snow.energy(F - d, J_P, ELASTIC)) / (2 * h)
    tau = snow.kirchhoff(F, J_P, ELASTIC)
    np.testing.assert_allclose(P @ np.swapaxes(F, 1, 2), tau, atol=1e-7 * ELASTIC.M_c)


def test_polar_svd_of_reflections():
    """U diag(sigma) V^T = F with det U = det V = 1, for matrices of both orientations."""
    F = np.random.default_rng(0).standard_normal((200, 3, 3))
    U, sigma, V = snow.polar_svd(F)
    np.testing.assert_allclose((U * sigma[:, None, :]) @ np.swapaxes(V, 1, 2), F, atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(U), 1, atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(V), 1, atol=1e-13)
    assert (sigma[:, 2] < 0).any()
    assert (np.abs(sigma[:, 2]) <= sigma[:, 1]).all()


def test_oedometer_table():
    """The Cauchy stress sigma_33 of a confined column compressed to s, in whole pascals."""
    table = {0.99: -1556, 0.975: -3889, 0.95: -5158, 0.9: -9092, 0.85: -16077, 0.8: -28526, 0.7: -90921}
    for s, expected in table.items():
        F_E, J_P = snow.return_map(np.diag([1.0, 1.0, s])[None], np.ones(1), Snow())
        sigma = snow.kirchhoff(F_E, J_P, Snow())[0, 2, 2] / s
        assert sigma == pytest.approx(expected, abs=0.6)


@pytest.mark.parametrize(("spline", "transfer"), COMBINATIONS)
def test_momentum(spline, transfer):
    """Internal forces move no momentum; with C, and tau symmetric, no angular momentum (to rounding).

    asflip's share of FLIP does move angular momentum: it brings back v_p, but not its C.
    """
    p, method = ball(spline, transfer)
    rng = np.random.default_rng(2)
    p.v = rng.standard_normal(p.v.shape)
    p.F_E = some_matrices(len(p.x), 0.02)
    before, L = step.momentum(p), step.angular_momentum(p, method)
    for _ in range(5):
        step.step(p, method, 1e-4)
    np.testing.assert_allclose(step.momentum(p), before, atol=1e-12)
    if transfer in ("apic", "polypic"):
        np.testing.assert_allclose(step.angular_momentum(p, method), L, atol=1e-12)


@pytest.mark.parametrize(("spline", "transfer"), COMBINATIONS)
def test_free_fall(spline, transfer):
    """v = -g n dt and z = z0 - g dt^2 n (n + 1) / 2."""
    g, dt, n = 9.81, 1e-3, 5
    p, method = ball(spline, transfer, gravity=(0, 0, -g))
    x0 = p.x.copy()
    for k in range(n):
        step.step(p, method, dt, first=k == 0)
    np.testing.assert_allclose(p.v, np.tile([0, 0, -g * n * dt], (len(p.x), 1)), atol=1e-12)
    np.testing.assert_allclose(p.x[:, 2] - x0[:, 2], -g * dt**2 * n * (n + 1) / 2, atol=1e-12)


def test_volume_from_the_grid():
    """Particles on a lattice of k^3 a cell have V0 = (dx/k)^3 inside.

    The lattice is k interleaved lattices of spacing dx per axis, over each of which a spline sums to one.
    """
    k, dx, cells = 2, 0.1, 8
    line = (np.arange(k * cells) + 0.5) * dx / k
    x = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3)
    p = step.Particles.at_rest(x, m=0.05, V0=0.0, law=Snow())
    step.step(p, step.Method(dx=dx, gravity=(0, 0, 0)), 1e-4, first=True)
    inside = ((x > 2.5 * dx) & (x < (cells - 2.5) * dx)).all(1)
    np.testing.assert_allclose(p.V0[inside], (dx / k) ** 3, rtol=1e-12)


@pytest.mark.parametrize("shape", ["plane", "box", "sphere", "cylinder"])
def test_normal_is_the_gradient_of_the_distance(shape):
    """n = grad phi by central differences with step h = 1e-6: h^2 / R^2 + eps / h < 1e-8."""
    rng, h = np.random.default_rng(3), 1e-6
    turn = snow.rotation(rng.standard_normal((1, 3, 3)))[0]
    size = {"plane": (), "box": (0.5, 0.8, 1.1), "sphere": (0.6,), "cylinder": (0.4, 0.9)}[shape]
    body = contact.Body(shape, size=size, position=np.array([0.1, -0.2, 0.3]), rotation=turn)
    x = rng.uniform(-1, 1, (300, 3))
    phi, n = body.distance(x)
    ahead = np.stack([body.distance(x + h * e)[0] for e in np.eye(3)], -1)
    behind = np.stack([body.distance(x - h * e)[0] for e in np.eye(3)], -1)
    slope = (ahead - behind) / (2 * h)
    smooth = np.abs(np.linalg.norm(slope, axis=1) - 1) < 1e-6  # phi has a crease on the medial axis
    assert smooth.mean() > 0.98
    np.testing.assert_allclose(n[smooth], slope[smooth], atol=1e-8)
    assert (phi < 0).any()
    assert (phi > 0).any()


def test_contact_laws():
    """Answers by hand on a floor with mu_c = 0.5; the rows press and slide, press and stick, leave."""
    v = np.array([[2.0, 0, -1], [0.3, 0, -1], [2.0, 0, 1]])
    n = np.tile([0.0, 0, 1], (3, 1))
    flat = n, np.zeros(len(n))
    separate = contact.relative(v, n, flat, "separate", 0.5)
    slip = contact.relative(v, n, flat, "slip", 0.5)
    np.testing.assert_allclose(separate, [[1.5, 0, 0], [0, 0, 0], [2, 0, 1]])
    np.testing.assert_allclose(slip, [[1.5, 0, 0], [0, 0, 0], [2, 0, 0]])
    np.testing.assert_array_equal(contact.relative(v, n, flat, "sticky", 0.5), 0)
