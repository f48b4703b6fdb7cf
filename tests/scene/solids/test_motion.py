"""Poses of scripted bodies: known places, and velocities that are the derivatives of the places."""

from __future__ import annotations

import numpy as np
import pytest

from neve.colliders.motion import path_of, pose
from neve.geometry.pose import Pose, rotation_matrix, rotation_vector
from neve.scene.schema.scene import Collider, Keyframe

RNG = np.random.default_rng(0)
KEYS = (
    Keyframe(t=0.5, position=(0.0, 0.0, 1.0), rotation=(0.0, 0.0, 0.0)),
    Keyframe(t=1.5, position=(2.0, 0.0, 1.0), rotation=(0.0, 0.0, 90.0)),
    Keyframe(t=2.0, position=(2.0, 1.0, 3.0), rotation=(40.0, -20.0, 120.0)),
)
MOVING: list[Collider] = [
    Collider.of("box", keyframes=KEYS),
    Collider.of("plane", normal=(0.3, -0.4, 0.8), keyframes=KEYS),
    Collider.of("sphere", velocity=(1.0, -2.0, 0.5), spin=(0.5, 2.0, -1.0)),
    Collider.of("cylinder", rotation=(30.0, 40.0, -70.0), velocity=(1.0, 0.0, 0.0), spin=(3.0, 0.0, 4.0)),
    Collider.of(
        "plane", normal=(1.0, 1.0, 0.0), point=(0.0, 0.0, 2.0), velocity=(0.0, 0.0, 1.0), spin=(0.0, 0.0, 1.0)
    ),
]


def test_turn_is_the_rotation_by_an_angle_about_an_axis() -> None:
    """rotation_matrix(w) keeps the axis, is orthogonal, of determinant 1, and its trace is 1 + 2 cos |w|."""
    for w in RNG.normal(size=(50, 3)) * 3.0:
        R = rotation_matrix(w)
        assert R @ w == pytest.approx(w, abs=1e-12)
        assert np.eye(3) == pytest.approx(R @ R.T, abs=1e-14)
        assert np.linalg.det(R) == pytest.approx(1.0)
        assert np.trace(R) == pytest.approx(1.0 + 2.0 * np.cos(np.linalg.norm(w)))
    assert rotation_matrix(np.array([0.0, 0.0, np.pi / 2])) @ [1.0, 0.0, 0.0] == pytest.approx(
        [0.0, 1.0, 0.0], abs=1e-15
    )


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1.0, 3.0, np.pi - 1e-8, np.pi])
def test_rotation_vector_undoes_turn(angle: float) -> None:
    """rotation_vector(rotation_matrix(w)) turns as w does, for angles from nothing to half a turn."""
    for axis in (*np.eye(3), -np.eye(3)[1], *RNG.normal(size=(20, 3))):
        w = angle * axis / np.linalg.norm(axis)
        back = rotation_vector(rotation_matrix(w))
        assert np.linalg.norm(back) == pytest.approx(angle, abs=1e-8)
        assert rotation_matrix(back) == pytest.approx(rotation_matrix(w), abs=1e-12)


@pytest.mark.parametrize("body", MOVING, ids=lambda body: f"{body.shape}-{len(body.keyframes)}")
@pytest.mark.parametrize("t", [0.2, 0.9, 1.7, 2.5])
def test_velocities_are_derivatives(body: Collider, t: float) -> None:
    """v = dx/dt and dR/dt = [omega]_x R, by central differences (error h^2 |omega|^3 / 6)."""
    h = 1e-5
    before, now, after = pose(body, t - h), pose(body, t), pose(body, t + h)
    assert (after.position - before.position) / (2 * h) == pytest.approx(now.velocity, abs=1e-8)
    rate = (after.rotation - before.rotation) / (2 * h)
    assert rate == pytest.approx(np.cross(now.omega, now.rotation.T).T, abs=1e-7)


def test_keyframes_are_met_and_held() -> None:
    """At a keyframe the body is where it says; before the first and after the last it rests there."""
    body = Collider.of("box", keyframes=KEYS)
    for key in KEYS:
        assert pose(body, key.t).position == pytest.approx(key.position)
        assert pose(body, key.t).rotation == pytest.approx(
            rotation_matrix(np.radians(key.rotation)), abs=1e-12
        )
    for t, key in ((0.0, KEYS[0]), (2.0, KEYS[2]), (9.0, KEYS[2])):
        resting = pose(body, t)
        assert resting.position == pytest.approx(key.position)
        assert not resting.velocity.any()
        assert not resting.omega.any()
    half = pose(body, 1.0)
    assert half.position == pytest.approx([1.0, 0.0, 1.0])
    assert half.rotation == pytest.approx(rotation_matrix(np.array([0.0, 0.0, np.pi / 4])), abs=1e-12)
    assert half.velocity == pytest.approx([2.0, 0.0, 0.0])
    assert half.omega == pytest.approx([0.0, 0.0, np.pi / 2])


def test_left_out_parts_of_a_keyframe_are_the_bodys_own() -> None:
    """A keyframe without position or rotation keeps the body's own."""
    body = Collider.of(
        "cylinder",
        center=(1.0, 2.0, 3.0),
        rotation=(90.0, 0.0, 0.0),
        keyframes=(Keyframe(t=0), Keyframe(t=1)),
    )
    resting = pose(body, 0.5)
    assert resting.position == pytest.approx([1.0, 2.0, 3.0])
    assert resting.rotation @ [0.0, 0.0, 1.0] == pytest.approx([0.0, -1.0, 0.0], abs=1e-15)


@pytest.mark.parametrize(
    "normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -2, 0), (1, 2, 3), (1e-9, 0, -1), (-1, 1e-7, -1)]
)
def test_z_of_a_plane_is_its_normal(normal: tuple[float, float, float]) -> None:
    """The frame of a plane is a proper rotation whose z is the normal."""
    R = pose(Collider.of("plane", normal=normal), 0.0).rotation
    assert R[:, 2] == pytest.approx(np.array(normal) / np.linalg.norm(normal), abs=1e-12)
    assert np.eye(3) == pytest.approx(R @ R.T, abs=1e-14)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_default_plane_is_the_ground() -> None:
    """The default plane has the world's own axes."""
    ground: Pose = pose(Collider.of("plane"), 3.0)
    assert np.array_equal(ground.rotation, np.eye(3))
    assert np.array_equal(ground.position, np.zeros(3))


def test_a_path_hands_the_engine_the_rotation_that_it_has() -> None:
    """`place` writes the position of `at`, and a quaternion whose matrix is the rotation, to rounding.

    Of half turns too, where its first component is 0.
    """
    turns = [(180.0, 0.0, 0.0), (0.0, 180.0, 0.0), (127.27922061357856, 127.27922061357856, 0.0)]
    turns += [tuple(row) for row in RNG.uniform(-180.0, 180.0, (20, 3)).tolist()]
    for turn in turns:
        keys = (Keyframe(t=0.0, rotation=(0.0, 0.0, 0.0)), Keyframe(t=1.0, rotation=turn))
        path = path_of(Collider.of("box", center=(1.0, 2.0, 3.0), keyframes=keys))
        for t in (0.0, 0.3, 1.0):
            position, rotation = path.at(t)[:2]
            written, q = np.zeros(3), np.zeros(4)
            path.place(t, written, q)
            assert np.array_equal(written, position)
            w, axis = q[0], q[1:]
            assert w >= 0.0
            across = np.cross(np.eye(3), axis)  # rows e_i x axis: minus the matrix of the cross product
            matrix = (w * w - axis @ axis) * np.eye(3) + 2.0 * np.outer(axis, axis) - 2.0 * w * across.T
            assert matrix == pytest.approx(rotation, abs=1e-14)
