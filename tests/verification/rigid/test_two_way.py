"""Bodies that the snow moves: what one gains the other loses, and light and heavy ones stay calm.

The bodies are the textbook's (verification/free_bodies.py), so that the contact is tested alone.
"""

import numpy as np
import pytest
from verification.free_bodies import FreeBodies, ball, block, simulate_with
from verification.scenes import box, scene

DX = 0.05


def hit(body, precision="float64", gravity=(0.0, 0.0, 0.0), colliders=(), snow=None, **numerics):
    """A block of snow under a body."""
    description = scene(
        [box(center=(0, 0, -0.15), size=(0.4, 0.4, 0.3))], colliders, gravity, snow=snow,
        precision=precision, initial_volume="sampled", **{"dt": "auto", **numerics},
    )  # fmt: skip
    return simulate_with(description, FreeBodies(body, gravity=gravity))


def momentum(sim):
    """Total momentum, and angular momentum about the origin.

    A particle's own part is sum_i w_ip m (x_i - x_p) x C (x_i - x_p) = m D axial(C), with D = dx^2 / 4.
    """
    bodies, s = sim.solver.model.rigid, sim.state
    m, x, v, C = (np.asarray(a, float) for a in (s.m, s.x, s.v, s.C))
    linear = (m[:, None] * v).sum(0) + bodies.momentum
    axial = np.stack([C[:, 2, 1] - C[:, 1, 2], C[:, 0, 2] - C[:, 2, 0], C[:, 1, 0] - C[:, 0, 1]], axis=1)
    angular = (m[:, None] * (np.cross(x, v) + DX**2 / 4 * axial)).sum(0)
    return linear, angular + sum(np.cross(b.x, b.mass * b.v) + b.I @ b.w for b in bodies.bodies)


@pytest.mark.parametrize("mode", ["separate", "slip", "sticky"])
@pytest.mark.parametrize("density", [20.0, 400.0, 8000.0])
def test_momentum(precision, eps, density, mode):
    """Without gravity snow and body together keep their momentum to rounding, at any ratio of masses.

    Known answer 43 with a body that moves: summed in double from values rounded to eps, so a step adds an
    error of eps sum m |v|, of random sign from particle to particle; steps eps sum m |v| bounds the sum.
    """
    body = block((0.2, 0.3, 0.2), density, mode, x=(0.03, -0.02, 0.13), v=(1.0, 0.3, -4.0), w=(2.0, 1.0, 3.0))
    sim = hit(body, precision)
    before, _ = momentum(sim)
    flux = float(np.abs(before).sum())
    sim.advance(0.03)
    after, _ = momentum(sim)
    assert np.abs(sim.exchanged[0, :3]).sum() > 0.02 * flux  # they did meet
    np.testing.assert_allclose(after, before, rtol=0, atol=sim.steps * eps * max(flux, 1.0))


def test_sticky_body_in_snow():
    """A sticky body deep in snow at rest shares its momentum at once with the nodes it holds.

    One step of dt -> 0, stress-free snow all around a small sticky ball: U' is the velocity at which what
    the ball loses is what the nodes gain, m (U' - U) + sum_i m_i U' = 0, so U' = m U / (m + sum m_i): the
    nodes' masses are read from the grid. By symmetry nothing turns it by more than the nodes' asymmetry;
    Newton stops at 1e-6 of the first residual.
    """
    body = ball(0.13, 300.0, x=(0.0, 0.0, -0.15), v=(0.0, 0.0, -3.0))
    body.solid.__dict__["mode"] = "sticky"
    sim = hit(body, dt=1e-9)
    sim.solver.begin(sim.steps, sim.time)
    core, native = sim.solver.model.core, sim.solver.model.native
    core.p2g(native, sim.state, sim.solver.grid, 1e-9)
    ijk, mass, _ = sim.solver.grid.nodes()
    arm = ijk * DX - body.x
    held = np.linalg.norm(arm, axis=1) <= 0.13 + 1e-4 * DX
    m, a = mass[held].astype(float), arm[held]
    # sum m_i B^T B of B = [1, -[a]x]: the inertia of the nodes about the ball's centre
    cross = np.array([[[0, -z, y], [z, 0, -x], [-y, x, 0]] for x, y, z in a])
    B = np.concatenate([np.broadcast_to(np.eye(3), (len(a), 3, 3)), -cross], axis=2)
    K = np.einsum("n,nki,nkj->ij", m, B, B)
    A = sim.solver.model.rigid.motion.mobility
    expected = np.linalg.solve(np.eye(6) + A @ K, np.array([0, 0, -3.0, 0, 0, 0]))
    core.grid_update(native, sim.solver.grid, 1e-9)
    _, _, v = sim.solver.grid.nodes()
    found, *_ = np.linalg.lstsq(B.reshape(-1, 6), v[held].reshape(-1).astype(float), rcond=None)
    np.testing.assert_allclose(found, expected, atol=1e-5)
    assert len(a) > 20


@pytest.mark.parametrize("density", [20.0, 100.0, 400.0, 8000.0])
def test_energy_never_grows(density):
    """A ball of 0.05 to 20 times the snow's density that hits it: no energy is made.

    Kinetic and elastic energy of both together. Contact without restitution only takes; the explicit step may
    give back 1 % of what was put in (measured: below 0.2 %).
    """
    sim = hit(ball(0.15, density, x=(0.01, 0.02, 0.16), v=(0.5, 0.0, -5.0), w=(0, 8.0, 0)), "float32")

    def energy():
        d = sim.diagnostics()
        return d.kinetic + d.affine + d.elastic + sim.solver.model.rigid.energy

    start = most = energy()
    least = start
    for _ in range(12):
        sim.advance(0.005)
        assert energy() < least + 0.01 * start
        least, most = min(least, energy()), max(most, energy())
    assert least < 0.98 * start
    assert np.linalg.norm(sim.solver.model.rigid.bodies[0].v) < 6.0


def test_body_at_rest_carries_its_weight():
    """A block that lies on snow is borne by it, and the ground bears both.

    Mean over 0.15 s after 0.25 s: the impulse on the block is its weight but for what momentum it still
    gains, exactly; and the weight alone to 5 %.
    """
    g = -10.0
    body = block((0.3, 0.3, 0.1), 600.0, x=(0, 0, 0.05 + 1e-3))
    ground = [{"shape": "plane", "point": (0, 0, -0.3)}]
    sim = hit(body, "float32", (0, 0, g), ground, snow={"plasticity": "none", "E0": 5e4})
    sim.advance(0.25)
    before, v = sim.exchanged[1, 2], body.v[2]
    sim.advance(0.15)
    force = (sim.exchanged[1, 2] - before) / 0.15
    assert force + body.mass * g == pytest.approx(body.mass * (body.v[2] - v) / 0.15, abs=1e-9 * body.mass)
    assert force == pytest.approx(-body.mass * g, rel=0.05)
    assert abs(body.x[0]) + abs(body.x[1]) < 0.2 * DX


def test_angular_momentum():
    """Snow and a turning body together keep their angular momentum about the origin.

    APIC keeps it in its transfers, impulses act on both at one point, and moving along v keeps x cross v.
    What is left are the ways of the few particles that turn within a step, which are not along their v at its
    end: for each at most m |v|^2 dt a step. Allowed: 1e-4 of what was exchanged.
    """
    body = block((0.2, 0.3, 0.2), 400.0, x=(0.03, -0.02, 0.13), v=(1.0, 0.3, -4.0), w=(2.0, 1.0, 3.0))
    sim = hit(body)
    before, start = momentum(sim)[1], body.I @ body.w + np.cross(body.x, body.mass * body.v)
    sim.advance(0.03)
    exchanged = np.linalg.norm(body.I @ body.w + np.cross(body.x, body.mass * body.v) - start)
    assert exchanged > 0.5
    np.testing.assert_allclose(momentum(sim)[1], before, rtol=0, atol=1e-4 * exchanged)


def test_same_bits_for_all_threads():
    """The response of the snow is summed block by block in a fixed order."""
    found = []
    for threads in (1, 2, 3):
        body = block((0.2, 0.3, 0.2), 50.0, x=(0.03, -0.02, 0.13), v=(1.0, 0.3, -4.0))
        sim = hit(body, "float32")
        sim.threads = threads
        sim.advance(0.01)
        found.append((np.array(sim.state.x).tobytes(), body.x.tobytes(), body.w.tobytes()))
    assert found[0] == found[1] == found[2]
