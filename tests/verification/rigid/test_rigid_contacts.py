"""Rigid bodies that touch: rest, friction, collisions, moving colliders; and going on from a saved state."""

import numpy as np
import pytest
from verification.loose import G, bodies_of, exchange, run

FLOOR = {"shape": "plane"}
SINK = 1.01 * (0.1 / 0.9) * G * (0.95 * 0.002) ** 2 / 0.9
"""Of a body at rest on one contact: (1 - d) g / (d k), k = d / (d_max tau)^2, with MuJoCo's impedance
d = 0.9, d_max = 0.95 and tau = 2 ms (its documentation, solver parameters): 4.4 micrometres [m]."""


@pytest.mark.parametrize("dt", [1e-5, 1e-4, 1e-3, 5e-3])
@pytest.mark.parametrize("density", [1.0, 20000.0])
def test_rests_without_sinking(dt, density):
    """A box on a plane sinks in by micrometres at most, whatever its density and the step."""
    rigid = bodies_of(
        [{"shape": "box", "size": [0.2] * 3, "center": [0, 0, 0.1], "density": density}], [FLOOR]
    )
    (pose,) = run(rigid, dt, int(min(max(0.1 / dt, 20), 2000)))
    assert -SINK < pose.position[2] - 0.1 <= 0.0
    assert np.abs(pose.velocity).max() < 1e-6


def test_falls_to_rest_on_every_shape():
    """A ball comes to rest on top of a plane, a box, a sphere's pole, a cylinder; it stays out of them."""
    tops = [
        {"shape": "plane", "point": [0, 0, 1.0]},
        {"shape": "box", "size": [1, 1, 1], "center": [0, 0, 0.5]},
        {"shape": "sphere", "radius": 1.0, "center": [0, 0, 0.0]},
        {"shape": "cylinder", "radius": 0.5, "height": 1.0, "center": [0, 0, 0.5]},
    ]
    for top in tops:
        rigid = bodies_of([{"shape": "sphere", "radius": 0.1, "center": [0, 0, 1.15]}], [top])
        (pose,) = run(rigid, 1e-3, 500)
        assert pose.position == pytest.approx([0, 0, 1.1], abs=SINK), top["shape"]


@pytest.mark.parametrize("speed", [10.0, 300.0, 5000.0])
@pytest.mark.parametrize("ground", [FLOOR, {"shape": "box", "size": [2, 2, 0.3], "center": [0, 0, -0.15]}])
def test_no_body_is_too_fast_for_the_ground(speed, ground):
    """However fast, a ball sinks in by less than half of its radius, and comes to rest there: a contact takes
    no longer than the ball to go what is left of that. It is stopped in v T / e, and pushed out with 1 / e
    of that in T: with v / e^2 at most.
    """
    ball = {"shape": "sphere", "radius": 0.1, "center": [0, 0, 0.3], "velocity": [0, 0, -speed]}
    rigid = bodies_of([ball], [ground], gravity=[0, 0, 0])
    dt = min(1e-4, 0.02 / speed)  # the way of a solid in a step is bounded
    path = [run(rigid, dt, 1)[0] for _ in range(int(3.0 / speed / dt))]
    assert 0.05 < min(at.position[2] for at in path) <= 0.1
    assert -2e-3 < path[-1].velocity[2] / speed < np.exp(-2)


def test_friction_holds_and_slides():
    """On a slope of tan = 0.4 a box with friction 0.5 stays, one with 0.3 slides.

    While it slides, the impulse of friction is 0.3 times the normal one, m (g cos t + v_n) with v_n the speed
    at which the box, which rocks a little, leaves the plane at the end: v = g t sin - 0.3 (g t cos + v_n).
    Friction is soft only until the box slides: 1 %. What holds creeps by well under a tenth of a millimetre.
    """
    slope = {"shape": "plane", "normal": [-0.4, 0.0, 1.0]}
    angle = np.arctan(0.4)
    down, normal = -np.array([np.cos(angle), 0, np.sin(angle)]), np.array([-np.sin(angle), 0, np.cos(angle)])
    table = {"shape": "box", "size": [0.2, 0.2, 0.1], "rotation": [0, -np.degrees(angle), 0]}
    for friction in (0.5, 0.3):
        box = {**table, "center": list(0.05 * normal), "friction": friction}
        (pose,) = run(bodies_of([box], [slope]), 1e-4, 5000)
        if friction == 0.5:
            assert np.linalg.norm(pose.position - 0.05 * normal) < 5e-5
        else:
            expected = 0.5 * G * np.sin(angle) - 0.3 * (0.5 * G * np.cos(angle) + pose.velocity @ normal)
            assert pose.velocity @ down == pytest.approx(expected, rel=0.01)


def test_collision_keeps_momentum():
    """Two bodies that hit each other keep their common momentum to rounding: 2 eps of it a step."""
    rigid = bodies_of(
        [
            {
                "shape": "box",
                "size": [0.2, 0.3, 0.4],
                "velocity": [2.0, 0.1, 0.0],
                "spin": [1, 2, 3],
                "mass": 0.5,
            },
            {
                "shape": "sphere",
                "radius": 0.3,
                "center": [0.6, 0.1, 0.5],
                "velocity": [-1, 0, 0],
                "mass": 9.0,
            },
        ],
        gravity=[0, 0, 0],
    )
    before = rigid.momentum
    start = rigid.poses()[0].velocity
    run(rigid, 1e-3, 300)
    assert np.linalg.norm(rigid.poses()[0].velocity - start) > 1.0  # they met
    assert rigid.momentum == pytest.approx(before, abs=600 * np.finfo(float).eps * 9.0)


def test_contact_acts_only_between_those_that_have_it():
    """`contacts = false` lets a body through colliders and other bodies."""
    tables = [
        {"shape": "sphere", "radius": 0.1, "center": [0, 0, 0.2], "contacts": False},
        {"shape": "sphere", "radius": 0.1, "center": [0, 0, 0.1]},
    ]
    through, kept = run(bodies_of(tables, [FLOOR]), 1e-3, 300)
    assert through.position[2] == pytest.approx(0.2 - 0.5 * G * 0.3 * 0.3005, abs=1e-9)
    assert kept.position[2] == pytest.approx(0.1, abs=SINK)


@pytest.mark.parametrize("speed", [0.3, 2.0])
def test_moving_collider_carries_a_body(speed):
    """A platform that rises and drifts takes a box along at its own velocity, without sinking in.

    At t = 0 it starts at once: the contact meets it in a few time constants, an arc of speed x 2 ms, and
    nothing is left of that 0.5 s later.
    """
    floor = {"shape": "box", "size": [2, 2, 0.2], "center": [0, 0, -0.1], "velocity": [0.1 * speed, 0, speed]}
    rigid = bodies_of([{"shape": "box", "size": [0.2] * 3, "center": [0, 0, 0.1]}], [floor])
    (pose,) = run(rigid, 1e-3, 500)
    assert pose.velocity == pytest.approx([0.1 * speed, 0, speed], abs=1e-3 * speed)
    top = speed * 0.5
    assert pose.position[2] - top == pytest.approx(0.1, abs=speed * 0.002)


def test_turning_collider_turns_a_body():
    """A turntable gives a box that stands on its middle its own angular velocity."""
    table = {"shape": "cylinder", "radius": 1.0, "height": 0.2, "center": [0, 0, -0.1], "spin": [0, 0, 2.0]}
    rigid = bodies_of([{"shape": "box", "size": [0.4, 0.4, 0.1], "center": [0, 0, 0.05]}], [table])
    (pose,) = run(rigid, 1e-3, 500)
    assert pose.omega == pytest.approx([0, 0, 2.0], abs=0.01)


def lively():
    """Bodies in contact with a moving collider and each other, and a motor at work."""
    return bodies_of(
        [
            {"shape": "box", "size": [0.2, 0.2, 0.2], "center": [0, 0, 0.35], "spin": [1, 2, 0]},
            {"shape": "cylinder", "radius": 0.2, "height": 0.2, "center": [0, 0.05, 0.1]},
            {"shape": "box", "size": [0.5, 0.1, 0.1], "center": [1, 0, 1], "joint": "hinge",
             "motor": {"target": 3.0}},
        ],
        [{"shape": "plane", "velocity": [0.1, 0, 0.05]}],
    )  # fmt: skip


def test_goes_on_with_the_same_bits():
    """A saved state goes on, in another engine, with the bits of a run in one go."""
    whole, first, second = lively(), lively(), lively()
    push = exchange([0.01, 0, 0, 0, 0, 0.001], [0] * 6, [0, 0.02, 0, 0, 0, 0])
    run(whole, 7e-4, 200, push)
    run(first, 7e-4, 90, push)
    second.restore(first.save())
    assert np.array_equal(second.motion.mobility, first.motion.mobility)
    run(second, 7e-4, 110, push, done=90)
    assert all(
        np.array_equal(a, b) for a, b in zip(whole.save().values(), second.save().values(), strict=True)
    )
    for a, b in zip(whole.poses(), second.poses(), strict=True):
        assert np.array_equal(a.position, b.position)
        assert np.array_equal(a.omega, b.omega)


def test_state_of_other_bodies_is_refused():
    """A state that belongs to other bodies is refused in one sentence."""
    with pytest.raises(ValueError, match="does not fit the scene"):
        bodies_of([{"shape": "box"}]).restore(lively().save())


def test_lost_body_is_told():
    """A push or a speed without bound ends in a sentence that names the body."""
    from neve.rigid.coupled_bodies import LostBody

    rigid = bodies_of([{"shape": "box"}, {"shape": "box", "center": [9, 0, 0]}])
    with pytest.raises(LostBody, match=r"the snow pushes bodies\.1 without a finite force at t = 0\.1 s"):
        rigid.advance(1e-3, exchange([0] * 6, [np.nan] * 6), 0.1)
    with pytest.raises(LostBody, match=r"bodies\.0 has no finite place or velocity at t = 0\.101 s"):
        rigid.advance(1e-3, exchange([1e100] * 6, [0] * 6), 0.1)
