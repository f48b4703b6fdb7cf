"""Axes and units of files: what is up, how long a metre is, and that nothing is mirrored."""

import numpy as np
import pytest

from neve.export.axes import Axes


@pytest.mark.parametrize("up", ["y", "z"])
def test_up_is_up_and_nothing_is_mirrored(up):
    """The world's z becomes `up`; R is a rotation, R^T R = 1 and det R = 1; lengths are scaled."""
    axes = Axes(up, 100.0)
    assert axes.lengths(np.array([[0.0, 0.0, 1.0]]))[0].tolist() == [
        0.0,
        *([0, 100] if up == "z" else [100, 0]),
    ]
    assert np.array_equal(axes.turn.T @ axes.turn, np.eye(3))
    assert np.linalg.det(axes.turn) == 1.0


@pytest.mark.parametrize("up", ["y", "z"])
def test_all_that_is_turned_turns_alike(up):
    """s R x of points, R a of directions, R A R^T of matrices; a pose takes points of a solid along."""
    rng = np.random.default_rng(5)
    x, a, A = rng.normal(size=(7, 3)), rng.normal(size=(7, 3)), rng.normal(size=(7, 3, 3))
    axes = Axes(up, 2.5)
    R = axes.turn
    np.testing.assert_allclose(axes.lengths(x), 2.5 * x @ R.T, rtol=1e-6)
    np.testing.assert_allclose(axes.directions(a), a @ R.T, rtol=1e-6)
    np.testing.assert_allclose(axes.tensors(A), R @ A @ R.T, rtol=1e-6)
    Q, _ = np.linalg.qr(A[0])
    pose = axes.pose(x[0], Q)
    inside = a @ Q.T + x[0]  # points a of the solid's own frame, in the world
    np.testing.assert_allclose(2.5 * a @ pose[:3, :3].T + pose[:3, 3], 2.5 * inside @ R.T, rtol=1e-6)
