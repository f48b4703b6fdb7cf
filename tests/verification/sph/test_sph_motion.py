"""Momentum, rotation, flow and hardening of smoothed particles."""

import numpy as np
import pytest
from verification.sph.common import SNOW, add_floor, block, prepare, smoothed, solve, world

FAR = 1e9
BALL = {"shape": "sphere", "radius": 0.2}


def advance(snow, model, dt, tolerance=1e-9):
    """Take one step of dt [s]."""
    prepare(snow, model)
    solve(snow, model, dt, tolerance)
    assert snow.advance(model, dt, FAR, FAR).taken


def momenta(snow):
    """Momentum and angular momentum."""
    m, x, v = (np.asarray(a) for a in (snow.m, snow.x, snow.v))
    return m @ v, (m[:, None] * np.cross(x, v)).sum(axis=0)


def rotation(axis, angle):
    """The rotation by `angle` about a unit vector (Rodrigues)."""
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


@pytest.mark.parametrize("tolerance", [1e-9, 1e-2])
def test_momentum_and_angular_momentum(tolerance):
    """Snow that is strained and moves at random keeps both, to rounding, however loosely it is solved.

    The angular momentum: sum x_i x f_i = 0 of a step's forces, since the corrected gradient is exact for a
    linear field, here of all particles; positions move along velocities, which adds nothing. 30 steps.
    """
    model = world()
    snow = block((6, 6, 6), jitter=0.2)
    rng = np.random.default_rng(1)
    snow.v[...] = 0.2 * rng.standard_normal((snow.count, 3)) + [1.0, 0.0, 0.0]
    prepare(snow, model)
    before, scale = momenta(snow), float(np.sum(snow.m)) * 2.0
    for _ in range(30):
        advance(snow, model, 1e-3, tolerance)
    after = momenta(snow)
    np.testing.assert_allclose(after[0], before[0], rtol=0, atol=1e-13 * scale)
    np.testing.assert_allclose(after[1], before[1], rtol=0, atol=1e-12 * scale)


def test_a_rigid_rotation_strains_nothing():
    """v = w x r for a hundred steps of 0.02 rad: F stays the identity to rounding.

    (I + dt W) F alone would stretch snow by dt^2 w^2 / 2 in each step: by 2 % here. Velocities are set anew
    in each step, so that the body turns as it should, and positions are turned exactly.
    """
    model = world()
    snow = block((6, 6, 6), low=(-0.125, -0.125, -0.125))
    axis, w, dt = np.array([0.36, 0.48, 0.8]), 10.0, 2e-3
    turn = rotation(axis, w * dt)
    for _ in range(100):
        x = np.array(snow.x)
        snow.v[...] = np.cross(w * axis, x)
        prepare(snow, model)
        u = np.array(snow.v)
        spin = snow.velocity_gradient(u)
        np.testing.assert_allclose(spin + np.swapaxes(spin, 1, 2), 0.0, atol=1e-11)
        snow.given[...] = 0.0
        snow.pressed[...] = 0.0
        snow.sheared[...] = 0.0
        order = np.array(snow.id)
        assert snow.advance(model, dt, FAR, FAR).taken
        snow.x[...] = (x @ turn.T)[np.argsort(order)][np.array(snow.id)]
    np.testing.assert_allclose(snow.F_E, np.broadcast_to(np.eye(3), (snow.count, 3, 3)), rtol=0, atol=1e-12)


def test_a_rotation_with_a_wall_strains_nothing():
    """Snow that turns with a wall that it touches: S is zero to rounding, and F stays the identity.

    With boundaries in L, but not in the gradient that it corrects, S would be 0.3 of the spin there.
    """
    model = world()
    snow = block((6, 6, 4), low=(-0.125, -0.125, 0.025))
    spin = np.array([3.0, -4.0, 12.0])
    add_floor(snow, model, spin=spin)
    snow.v[...] = np.cross(spin, np.array(snow.x))
    prepare(snow, model)
    snow.find_given(model, 1e-3)
    np.testing.assert_allclose(snow.given, 0.0, atol=1e-9)  # it does not rub on what it turns with
    for name in ("given", "pressed", "sheared"):
        getattr(snow, name)[...] = 0.0
    assert snow.advance(model, 1e-3, FAR, FAR).taken
    np.testing.assert_allclose(snow.F_E, np.broadcast_to(np.eye(3), (snow.count, 3, 3)), rtol=0, atol=1e-13)


@pytest.mark.parametrize("counts", [(2, 1, 1), (5, 1, 1), (4, 4, 1), (2, 2, 2)])
def test_lines_and_sheets_turn_without_strain(counts):
    """Where particles have no neighbours in some direction a rotation strains nothing either.

    So their angular momentum holds, too: a stress s gives the moment sum V (P dev s P), which is symmetric.
    """
    model = world()
    snow = block(counts, jitter=0.2)
    rng = np.random.default_rng(4)
    snow.v[...] = 0.2 * rng.standard_normal((snow.count, 3))
    prepare(snow, model)
    D = snow.velocity_gradient(np.cross([3.0, -4.0, 12.0], np.array(snow.x)))
    np.testing.assert_allclose(D + np.swapaxes(D, 1, 2), 0.0, atol=1e-11)
    before = momenta(snow)[1]
    for _ in range(10):
        advance(snow, model, 1e-3, 1e-6)
    np.testing.assert_allclose(momenta(snow)[1], before, rtol=0, atol=1e-12 * float(np.sum(snow.m)))


def power_lost(A, dt, nu=0.2):
    """(d kinetic + d elastic) over |d kinetic| in a short step of a cube strained by A, which flows."""
    model = world(plasticity="none", xi=0.0, nu=nu)
    snow = block((7, 7, 7), jitter=0.1)
    snow.F_E[...] = np.eye(3) + A
    flow = np.random.default_rng(7).standard_normal((3, 3))
    snow.v[...] = (np.array(snow.x) - 0.15) @ (flow + 3.0 * np.eye(3))
    prepare(snow, model)
    first = snow.totals(model)
    solve(snow, model, dt, 1e-12)
    assert snow.advance(model, dt, FAR, FAR).taken
    prepare(snow, model)
    now = snow.totals(model)
    kinetic, elastic = now.kinetic - first.kinetic, now.elastic - first.elastic
    assert elastic * kinetic < 0
    return (kinetic + elastic) / abs(kinetic)


SHEARED = np.array([[1.0, 0.3, 0.0], [0.3, -0.5, 0.2], [0.0, 0.2, 0.4]])


@pytest.mark.parametrize("strain", [1e-2, 1e-3])
def test_the_log_has_the_energy_of_the_forces(strain):
    """What the forces take from the motion the elastic energy gains, to the order of the strains, dt -> 0.

    Of order dt is what backward Euler damps: twice the half step less the whole leaves it out.
    """
    whole, half = (power_lost(strain * SHEARED, dt) for dt in (2e-7, 1e-7))
    assert abs(2 * half - whole) < strain


def test_the_energy_of_pressure_is_exact():
    """lam (J - 1 - ln J): of snow with nu = 0.49, pressed by 2 % along each axis, 0.03 % is left.

    With lam (J - 1)^2 / 2, of the pressure lam (1 - J), six per cent would be; lam is 49 G.
    """
    whole, half = (power_lost(-0.02 * np.eye(3), dt, nu=0.49) for dt in (2e-7, 1e-7))
    assert abs(2 * half - whole) < 4e-3


def test_a_stretch_turns_with_the_snow():
    """Snow stretched along x that turns by 90 degrees about z is stretched along y then, by as much."""
    model = world(plasticity="none")
    snow = block((5, 5, 5), low=(-0.1, -0.1, -0.1))
    snow.F_E[...] = np.diag([1.01, 1.0, 0.995])
    steps = 200
    dt = 1e-3
    # Cayley's transform turns by 2 atan(w dt / 2) in each step
    w = 2 * np.tan(np.pi / 2 / steps / 2) / dt
    for _ in range(steps):
        snow.v[...] = np.cross([0.0, 0.0, w], np.array(snow.x))
        prepare(snow, model)
        for name in ("given", "pressed", "sheared"):
            getattr(snow, name)[...] = 0.0
        x, order = np.array(snow.x), np.array(snow.id)
        assert snow.advance(model, dt, FAR, FAR).taken
        snow.x[...] = (x @ rotation(np.array([0.0, 0.0, 1.0]), np.pi / 2 / steps).T)[np.argsort(order)][
            np.array(snow.id)
        ]
    expected = np.broadcast_to(np.diag([1.0, 1.01, 0.995]), (snow.count, 3, 3))
    np.testing.assert_allclose(snow.F_E, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("angle", [0.0, 0.6])
def test_only_stretches_are_clamped(angle):
    """A stretch of -10 %, +10 % and 0.1 % along turned axes becomes -theta_c, +theta_s and 0.1 % along them.

    A clamp of all entries would leave 1 - theta_c off the diagonal.
    """
    model = world()
    snow = block((3, 3, 3))
    R = rotation(np.array([0.36, 0.48, 0.8]), angle)
    snow.F_E[...] = R @ np.diag([0.9, 1.1, 1.001]) @ R.T
    prepare(snow, model)
    for name in ("given", "pressed", "sheared"):
        getattr(snow, name)[...] = 0.0
    assert snow.advance(model, 1e-3, FAR, FAR).taken
    expected = R @ np.diag([1 - SNOW["theta_c"], 1 + SNOW["theta_s"], 1.001]) @ R.T
    np.testing.assert_allclose(snow.F_E, np.broadcast_to(expected, (27, 3, 3)), rtol=0, atol=1e-13)
    assert np.abs(np.array(snow.F_E) - np.swapaxes(np.array(snow.F_E), 1, 2)).max() < 1e-16


def test_a_linear_flow_strains_as_it_flows():
    """Inside a lattice the gradient of a linear velocity is exact, and F grows by dt S F."""
    model = world(plasticity="none")
    snow = block((9, 9, 9))
    A = np.array([[0.1, 0.3, 0.0], [-0.2, -0.3, 0.1], [0.0, 0.4, 0.2]])
    snow.v[...] = np.array(snow.x) @ A.T
    prepare(snow, model)
    for name in ("given", "pressed", "sheared"):
        getattr(snow, name)[...] = 0.0
    x = np.array(snow.x)
    assert snow.advance(model, 1e-2, FAR, FAR).taken
    inside = np.all((x > 0.09) & (x < 0.31), axis=1)
    S = np.eye(3) + 1e-2 * 0.5 * (A + A.T)
    turned = rotation_of(1e-2 * 0.5 * (A - A.T))
    # the volume part is that of the uncorrected sum, some 1e-4 off on a lattice
    np.testing.assert_allclose(
        snow.F_E[inside], np.broadcast_to(turned @ S @ turned.T, (inside.sum(), 3, 3)), atol=2e-6
    )


def rotation_of(K):
    """Cayley's transform of a skew matrix."""
    return np.linalg.solve(np.eye(3) - K / 2, np.eye(3) + K / 2)


def test_denser_snow_is_stiffer_by_stomakhins_law():
    """Compressed to J of its volume with F = I, snow has J_P = J and moduli times exp(xi (1 - J))."""
    model = world()
    for J in (1.0, 0.9, 0.8):
        snow = block((9, 9, 9))
        snow.rho_birth[...] = 400.0
        snow.x[...] *= J ** (1 / 3)
        prepare(snow, model)
        middle = np.argmin(np.linalg.norm(np.asarray(snow.x) - np.asarray(snow.x).mean(axis=0), axis=1))
        # closer together, neighbours from beyond the support add some per cent to the kernel's sum
        assert snow.J_P[middle] == pytest.approx(J, rel=0.03)
        grown = np.exp(10.0 * (1.0 - float(snow.J_P[middle])))
        assert snow.G[middle] == pytest.approx(grown * 1.4e5 / 2.4, rel=1e-12)
        assert snow.lam[middle] == pytest.approx(grown * 1.4e5 * 0.2 / (1.2 * 0.6), rel=1e-12)


def test_a_lone_particle_falls():
    """It has no gradient in any direction; nothing is divided by zero, and v = g t to rounding."""
    sim = smoothed([BALL | {"radius": 0.02}], gravity=(0.0, 0.0, -9.81), dx=0.04, dt=1e-3)
    assert sim.count == 1
    sim.advance(0.1)
    assert sim.state.v[0, 2] == pytest.approx(-0.981, rel=1e-12)
    np.testing.assert_allclose(sim.state.F_E[0], np.eye(3), rtol=0, atol=1e-15)


def test_a_ball_in_flight_keeps_its_shape():
    """Nothing acts but gravity: after half a second all particles are where the parabola has them."""
    sim = smoothed([BALL | {"velocity": (3.0, 0.0, 1.0)}], gravity=(0.0, 0.0, -9.81))
    x = np.array(sim.state.x)[np.argsort(sim.state.id)]
    sim.advance(0.5)
    after = np.array(sim.state.x)[np.argsort(sim.state.id)]
    moved = after - x
    np.testing.assert_allclose(moved, np.broadcast_to(moved[0], moved.shape), rtol=0, atol=1e-9)
    assert moved[0, 0] == pytest.approx(1.5, rel=1e-12)
