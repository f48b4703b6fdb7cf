"""Rigid bodies in the engine, without snow: momentum, moments, mobility, joints, motors, contacts."""

import numpy as np
import pytest
from verification.loose import G, bodies_of, exchange, run

from neve.geometry.pose import rotation_matrix
from neve.scene.errors import SceneError

EPS = np.finfo(float).eps
BOX = {"shape": "box", "size": [0.2, 0.3, 0.5], "rotation": [20.0, -40.0, 70.0], "center": [1.0, 2.0, 3.0]}


def box_inertia(mass, size):
    """Moments of a box about its axes: m (b^2 + c^2) / 12."""
    squares = np.square(size)
    return mass * np.diag(squares.sum() - squares) / 12.0


@pytest.mark.parametrize("dt", [1e-5, 1e-3, 4e-3])
def test_free_fall(dt):
    """z = z0 - g t^2 / 2, with the error g t h / 2 of steps h in which the new speed moves the body.

    v_n = -g n h and z_n = z0 - g h^2 n (n + 1) / 2 to rounding: a few eps a step.
    """
    rigid = bodies_of([BOX])
    steps = round(0.1 / dt) if dt > 1e-4 else 500
    (pose,) = run(rigid, dt, steps)
    t, h = steps * dt, min(dt, 5e-4)
    assert pose.velocity == pytest.approx([0.0, 0.0, -G * t], abs=20 * steps * EPS)
    assert pose.position == pytest.approx([1.0, 2.0, 3.0 - 0.5 * G * t * (t + h)], abs=20 * steps * EPS)


@pytest.mark.parametrize("density", [1.0, 300.0, 20000.0])
@pytest.mark.parametrize("dt", [1e-5, 2.7e-3])
def test_impulse_is_momentum(density, dt):
    """m dv = P + m g dt to rounding, wherever the impulse attacks and in however many steps of the engine.

    Each step rounds a velocity of some |v| twice: 10 eps |v| m covers ten steps.
    """
    rigid = bodies_of([{**BOX, "density": density, "velocity": [1.0, -2.0, 0.5], "spin": [3.0, 1.0, -2.0]}])
    mass = density * 0.03
    before = rigid.momentum
    P = mass * np.array([0.3, -0.7, 1.1])
    rigid.advance(dt, exchange([*P, *(0.02 * P[::-1])]), 0.0)
    change = P + mass * dt * np.array([0.0, 0.0, -G])
    assert rigid.momentum - before == pytest.approx(change, abs=40 * EPS * np.abs(before).max())


def test_moment_turns_the_body():
    """From rest a moment L turns a body at I^-1 L, I in the axes of the turned body, to rounding."""
    rigid = bodies_of([{**BOX, "mass": 7.0}], gravity=[0, 0, 0])
    L = np.array([0.2, -0.1, 0.3])
    R = rotation_matrix(np.radians(BOX["rotation"]))
    (pose,) = run(rigid, 1e-6, 1, exchange([0, 0, 0, *L]))
    expected = R @ np.linalg.solve(box_inertia(7.0, BOX["size"]), R.T @ L)
    assert pose.omega == pytest.approx(expected, rel=1e-5)  # it turns by 1e-6 s x 10 rad/s meanwhile
    assert rigid.angular_momentum == pytest.approx(L, rel=1e-5)


def test_torque_free_spin_keeps_angular_momentum():
    """A tumbling body keeps its angular momentum, up to the engine's first order in time.

    An error of a share |omega| h / 2 of |L| for each radian is what a first-order step may make: over
    1 s at |omega| = 3 rad/s and h = 1e-4 s that is 4.5e-4.
    """
    rigid = bodies_of([{**BOX, "spin": [2.0, -1.0, 2.0]}], gravity=[0, 0, 0])
    before, energy = rigid.angular_momentum, rigid.kinetic
    run(rigid, 1e-4, 10_000)
    assert np.abs(rigid.angular_momentum - before).max() < 4.5e-4 * np.linalg.norm(before)
    assert energy * (1 - 9e-4) < rigid.kinetic <= energy * (1 + 1e-12)


def test_mobility_is_the_response():
    """A dP is the change of the velocities that an impulse makes, for free, hinged and joined bodies.

    A step of dt = 1e-7 s turns the bodies by some 1e-7 s x 10 rad/s, and changes the velocities by as much.
    """
    tables = [
        {**BOX, "mass": 2.0},
        {"shape": "cylinder", "radius": 0.2, "height": 0.1, "center": [1.4, 2.0, 3.0], "mass": 1.0,
         "joint": "hinge", "axis": [0, 1, 1], "anchor": [1.3, 2.0, 3.0], "parent": 0},
        {"shape": "sphere", "radius": 0.3, "joint": "slide", "axis": [1, 2, 0], "mass": 3.0},
    ]  # fmt: skip
    rigid = bodies_of(tables, gravity=[0, 0, 0])
    rng = np.random.default_rng(1)
    P = rng.normal(size=18)
    before = np.concatenate([[*p.velocity, *p.omega] for p in rigid.poses()])
    expected = rigid.motion.mobility @ P
    after = run(rigid, 1e-7, 1, exchange(*P.reshape(3, 6)))
    change = np.concatenate([[*p.velocity, *p.omega] for p in after]) - before
    assert change == pytest.approx(expected, abs=2e-5 * np.abs(expected).max())
    assert rigid.motion.mobility == pytest.approx(rigid.motion.mobility.T, abs=0)


def test_mobility_of_a_free_body():
    """About its centre of mass a free body has A = diag(1 / m, R I^-1 R^T)."""
    rigid = bodies_of([{**BOX, "mass": 4.0}])
    R = rotation_matrix(np.radians(BOX["rotation"]))
    expected = np.zeros((6, 6))
    expected[:3, :3] = np.eye(3) / 4.0
    expected[3:, 3:] = R @ np.linalg.inv(box_inertia(4.0, BOX["size"])) @ R.T
    assert rigid.motion.mobility == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def hinged(**more):
    """A plate of 2 kg, 0.4 m wide along x, that hangs from its upper edge: a gate that swings about y."""
    return {"shape": "box", "size": [0.02, 1.0, 0.4], "center": [0.0, 0.0, -0.2], "mass": 2.0,
            "joint": "hinge", "axis": [0, 2, 0], "anchor": [0.0, 3.0, 0.0], **more}  # fmt: skip


INERTIA = 2.0 * (0.4**2 + 0.02**2) / 12.0 + 2.0 * 0.2**2
"""Of that plate about its hinge: m (a^2 + c^2) / 12 + m d^2."""


def test_mobility_of_a_hinge():
    """Only the turn about the axis yields: A = u u^T / I, u = (n x r, n), r from the hinge to the frame."""
    A = bodies_of([hinged()]).motion.mobility
    n, r = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -0.2])
    u = np.concatenate([np.cross(n, r), n])
    assert pytest.approx(np.outer(u, u) / INERTIA, abs=1e-13) == A


def test_pendulum_swings_with_its_period():
    """T = 2 pi sqrt(I / (m g d)) (1 + a^2 / 16), next term 11 a^4 / 3072; measured between two crossings.

    Released by a spin at the bottom: amplitude a = spin / w. The scheme is symplectic: its period is off by
    (w h)^2 / 24 and its energy swings by w h / 2 of itself without drifting.
    """
    w = np.sqrt(2.0 * G * 0.2 / INERTIA)
    rigid = bodies_of([hinged(spin=[0.0, 0.2 * w, 0.0])])
    period = 2 * np.pi / w * (1 + 0.2**2 / 16)
    h = 1e-3
    start = rigid.kinetic + rigid.potential
    x, crossings, energies = [0.0], [], []
    for i in range(int(2.1 * period / h)):
        (pose,) = run(rigid, h, 1, done=i)
        x.append(pose.position[0])
        energies.append(rigid.kinetic + rigid.potential - start)
        if x[-2] > 0 >= x[-1]:
            crossings.append(h * (i + x[-2] / (x[-2] - x[-1])))
    (pair,) = np.diff(crossings)
    assert pair == pytest.approx(period, rel=2 * 11 * 0.2**4 / 3072 + (w * h) ** 2)
    assert np.abs(energies).max() < w * h * (0.5 * INERTIA * (0.2 * w) ** 2)


@pytest.mark.parametrize("dt", [1e-4, 5e-4])
def test_motor_reaches_its_speed(dt):
    """dw/dt = gain (target - w) / I, taken implicitly: w_n = target (1 - (1 + h gain / I)^-n) to rounding."""
    motor = {"kind": "velocity", "target": 6.0, "gain": 2.0}
    rigid = bodies_of([hinged(motor=motor)], gravity=[0, 0, 0])
    steps = round(0.05 / dt)
    (pose,) = run(rigid, dt, steps)
    expected = 6.0 * (1.0 - (1.0 + dt * 2.0 / INERTIA) ** -steps)
    assert pose.omega == pytest.approx([0.0, expected, 0.0], rel=1e-10)


def test_motor_without_a_gain():
    """Left out, the gain is such that the bare body is within 5 % of its target after about 0.05 s."""
    speed = bodies_of([hinged(motor={"target": 6.0})], gravity=[0, 0, 0])
    (pose,) = run(speed, 1e-4, 520)
    assert pose.omega[1] == pytest.approx(6.0, rel=0.05)
    place = bodies_of([hinged(motor={"kind": "position", "target": 30.0})], gravity=[0, 0, 0])
    (pose,) = run(place, 1e-4, 520)
    assert np.degrees(np.arctan2(-pose.position[0], -pose.position[2])) == pytest.approx(30.0, rel=0.05)
    (pose,) = run(place, 1e-4, 2000)
    assert pose.position == pytest.approx(0.2 * np.array([-0.5, 0.0, -np.sqrt(0.75)]), abs=1e-6)


def test_motor_follows_its_keyframes_within_its_limit():
    """A torque of 0 to 3 N m in 0.1 s, cut at 2 N m: the speed is the integral of min(30 t, 2) / I.

    Rectangles of h = 1e-4 s from the left are short of the ramp's integral by 2 h / 2.
    """
    motor = {"kind": "torque", "limit": 2.0, "keyframes": [{"t": 0.0}, {"t": 0.1, "value": 3.0}]}
    rigid = bodies_of([hinged(motor=motor)], gravity=[0, 0, 0])
    (pose,) = run(rigid, 1e-4, 2000)
    impulse = 0.5 * 2.0 * (2.0 / 30.0) + 2.0 * (0.2 - 2.0 / 30.0)
    assert pose.omega[1] * INERTIA == pytest.approx(impulse, abs=1.01e-4)


def test_limits_stop_a_hinge():
    """A gate that is pushed stops at its limit, within what a stop of 2 ms gives way at 3 rad/s.

    A critical spring and damper would push until 2 v / w + x = 0, with x = u t exp(-w t) at w t = 2, when
    v = -u exp(-2): a stop, which cannot pull, throws back up to 14 % of the speed u.
    """
    rigid = bodies_of([hinged(limits=[-20.0, 45.0], spin=[0.0, 3.0, 0.0])], gravity=[0, 0, 0])
    angles = []
    for i in range(1000):
        (pose,) = run(rigid, 1e-3, 1, done=i)
        angles.append(np.degrees(np.arctan2(-pose.position[0], -pose.position[2])))
    assert 45.0 - 1e-3 < max(angles) < 45.0 + np.degrees(3.0 * 0.002)
    assert abs(pose.omega[1]) < 1.05 * np.exp(-2) * 3.0


def test_motor_inside_a_free_pair_keeps_momentum():
    """A motor between two free bodies turns both and moves neither's common centre, nor changes L.

    Joined bodies are stepped in joint coordinates, so that p and L hold to first order in h; here, in 0.1 s
    at up to 50 rad/s, within a thousandth of what turns.
    """
    motor = {"kind": "torque", "target": 0.2}
    arm = {"shape": "box", "size": [0.5, 0.1, 0.1], "center": [0.3, 0, 0], "mass": 1.0, "joint": "hinge",
           "axis": [0, 0, 1], "anchor": [0, 0, 0], "parent": 0, "motor": motor}  # fmt: skip
    rigid = bodies_of(
        [{"shape": "cylinder", "radius": 0.3, "height": 0.2, "mass": 2.0}, arm], gravity=[0, 0, 0]
    )
    run(rigid, 1e-4, 1000)
    first, second = rigid.poses()
    assert first.omega[2] < -0.05
    assert second.omega[2] > 0.05
    assert np.abs(rigid.momentum).max() < 1e-3 * np.linalg.norm(second.velocity)
    assert np.abs(rigid.angular_momentum).max() < 1e-3 * 0.2 * 0.1


def test_free_acceleration_is_what_happens():
    """Without snow the velocities change by dt times the free acceleration, whatever acts: gravity, the turn
    of frames away from the joint, a contact, a motor within and at its limit.

    A step of dt = 1e-6 s changes accelerations of 1e3 m/s2 by the share 1e-6 s x 100 /s. A motor with
    dt gain / I = 1 is met as well, since the engine's own implicit step is asked; after one step of that
    length, for which it was not yet known. Asking changes nothing.
    """
    tables = [
        hinged(spin=[0.0, 3.0, 0.0]),
        hinged(center=[9.0, 0.0, -0.2], anchor=[9.0, 0.0, 0.0],
               motor={"target": 5.0, "gain": INERTIA / 1e-6}),
        hinged(center=[6.0, 0.0, -0.2], anchor=[6.0, 0.0, 0.0], motor={"target": 5.0, "limit": 0.5}),
        {**BOX, "spin": [5.0, 1.0, 2.0]},
        {"shape": "box", "size": [0.2, 0.2, 0.2], "center": [-3.0, 0.0, 0.0999], "mass": 2.0},
    ]  # fmt: skip
    ground = {"shape": "plane", "normal": [0, 0, 1], "point": [0, 0, 0], "velocity": [0, 0, 0.01]}
    for table in tables[:3]:
        table["contacts"] = False
    rigid, silent = bodies_of(tables, [ground]), bodies_of(tables, [ground])
    run(rigid, 1e-6, 1), run(silent, 1e-6, 1)
    before = np.array([[*p.velocity, *p.omega] for p in rigid.poses()])
    expected = rigid.motion.acceleration
    sizes = np.abs(expected).max(axis=1)
    assert np.all(sizes > [1.0, 1e5, 0.5, 9.0, 10.0])  # all are at work
    after = np.array([[*p.velocity, *p.omega] for p in run(rigid, 1e-6, 1, done=1)])
    wrong = np.abs((after - before) / 1e-6 - expected).max(axis=1)
    assert np.all(wrong < 1e-4 * sizes)
    run(silent, 1e-6, 1, done=1)
    assert np.array_equal(rigid.save()["engine"], silent.save()["engine"])


def test_mobility_knows_of_motors():
    """A motor that holds its speed lets impulses turn its hinge the less: A = u u^T / (I + h gain)."""
    rigid = bodies_of([hinged(motor={"target": 0.0, "gain": 3.0 * INERTIA / 1e-4})], gravity=[0, 0, 0])
    bare = bodies_of([hinged()], gravity=[0, 0, 0])
    run(rigid, 1e-4, 1)
    assert rigid.motion.mobility == pytest.approx(bare.motion.mobility / 4.0, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ({"shape": "sphere", "radius": 1e-3, "density": 1.0}, "bodies.0 has a mass of 4.19e-09 kg"),
        ({**BOX, "mass": 1e-15}, "bodies.0 has a mass of 1e-15 kg"),
    ],
)
def test_body_too_light_for_the_engine_is_told(shape, said):
    """What the engine would refuse with a message of its own is one sentence of ours."""
    with pytest.raises(SceneError) as told:
        bodies_of([shape])
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_ground_bears_a_light_body():
    """What lies on the ground gives way to a push as the engine says, not like a body in the air.

    The velocity with a push down of 100 times its weight, less that without, is A P after one step of the
    engine: its constraints are linear as long as they hold. Rounding of its solver: 1e-6 of P / m.
    """
    box = {"shape": "box", "size": [0.4, 0.4, 0.1], "center": [0, 0, 0.05], "density": 20.0}
    ground = [{"shape": "plane"}]
    P = np.array([0.0, 0.0, -100 * 0.32 * G * 1e-4, 0.0, 0.0, 0.0])
    pushed, alone = bodies_of([box], ground), bodies_of([box], ground)
    for rigid in (pushed, alone):
        run(rigid, 1e-4, 200)
    expected = pushed.motion.mobility @ P
    for rigid, push in ((pushed, P), (alone, 0 * P)):
        rigid.advance(1e-4, exchange(push), 0.02)
    change = pushed.poses()[0].velocity - alone.poses()[0].velocity
    free = P[2] / 0.32
    assert change[2] == pytest.approx(expected[2], abs=1e-6 * abs(free))
    assert abs(change[2]) < 0.2 * abs(free)
