"""Grains that go with their snow: they turn where it turns, shear where it shears, and are never needles."""

import numpy as np
import pytest

from neve import _surface
from neve.surface.carry import NEIGHBOURS, Origin, carried
from neve.surface.grains import grains_of

RNG = np.random.default_rng(12)
H = 0.1
X = ((np.stack(np.meshgrid(*[np.arange(8)] * 3, indexing="ij"), -1).reshape(-1, 3) + 0.5) * H).astype(
    np.float32
)
ID = np.arange(len(X)) * 3 + 5
DEEP = (np.abs(X - 0.4) < 0.2).all(axis=1)


def rotation(seed):
    """A random rotation."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


def grains_after(F, shift=(0.3, -0.2, 0.5), x=X):
    """Grains (n, 27, 3) beside their particles, of snow that was `X` and has been moved to `x` by F."""
    now = (x @ F.T + shift).astype(np.float32)
    grains = grains_of(now, ID, H, 27, carried(Origin(ID, X).gradients(ID, now)))
    return grains.x.reshape(-1, 27, 3) - now[:, None], grains.lone


@pytest.mark.parametrize("seed", range(3))
def test_grains_turn_with_a_body(seed):
    """Snow that turns by R as a whole has its grains turned by R, to the thousandth that holds F back."""
    R = rotation(seed)
    before, _ = grains_after(np.eye(3))
    after, lone = grains_after(R)
    within = DEEP & (lone == 0)
    assert within.sum() > 40
    assert np.abs(after - before @ R.T)[within].max() < 0.01 * H


def test_grains_shear_with_their_snow():
    """In simple shear x' = x + g y a grain goes as far as its place beside the particle says."""
    shear = np.array([[1.0, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    before, _ = grains_after(np.eye(3))
    after, _ = grains_after(shear)
    assert np.abs(after - before @ shear.T)[DEEP].max() < 0.01 * H
    assert np.abs(after - before)[DEEP].max() > 0.1 * H


def test_gradients_are_those_of_the_motion():
    """An affine motion x' = F x has the gradient F at each particle, whatever their order."""
    F = rotation(4) @ np.diag([1.2, 0.9, 0.8])
    order = RNG.permutation(len(X))
    now = (X @ F.T)[order]
    found = Origin(ID, X).gradients(ID[order], now)
    assert np.abs(found - F).max() < 0.02


@pytest.mark.parametrize("F", [np.diag([8.0, 1.0, 1.0]), np.diag([0.1, 1.0, 3.0]), np.diag([1.0, 1.0, -1.0])])
def test_torn_snow_has_no_needles(F):
    """Stretches are kept from 0.65 to 1.5, those between are as they are; nothing is turned inside out."""
    R = rotation(7)
    found = carried((R @ F)[None].astype(np.float32))
    sigma = np.linalg.svd(found.offset[0], compute_uv=False)
    assert sigma == pytest.approx(np.sort(np.clip(np.diag(F), 0.65, 1.5))[::-1], rel=1e-4)
    for part in (found.offset, found.turn):
        assert np.linalg.det(part[0]) > 0
    assert found.turn[0] @ found.turn[0].T == pytest.approx(np.eye(3), abs=1e-5)


def test_who_has_lost_all_neighbours_is_not_turned():
    """A particle far from its neighbours, or without any, has F = 1; so have those that came later. Snow that
    lost some particles still turns."""
    origin, R = Origin(ID, X), rotation(2)
    now = (X @ R.T).astype(np.float32)
    now[0] += 50.0
    found = origin.gradients(np.append(ID, 4), np.append(now, [[0, 0, 0]], axis=0))
    assert found[[0, -1]] == pytest.approx(np.stack([np.eye(3)] * 2), abs=1e-6)
    some = np.flatnonzero(RNG.random(len(X)) < 0.8)
    left = origin.gradients(ID[some], now[some])
    turned = carried(left).turn[DEEP[some] & (some > 0)]
    assert np.abs(turned - R).max() < 0.1
    for few in (0, 1):
        lone = Origin(ID[:few], X[:few])
        assert lone.gradients(ID[:3], X[:3]) == pytest.approx(np.stack([np.eye(3)] * 3))


def test_gradients_change_little_when_snow_does():
    """Neighbours leave little by little: a particle that moves by a hundredth of a spacing has about the same
    F at any distance, of a whole body and of two particles."""
    whole, pair = Origin(ID, X), Origin(ID[:2], X[:2])
    for origin, one, n in ((whole, int(np.flatnonzero(DEEP)[0]), len(X)), (pair, 1, 2)):
        found = []
        for far in np.arange(0.0, 8.0, 0.01):
            now = X[:n].copy()
            now[one, 2] += far * H
            found.append(origin.gradients(ID[:n], now)[one])
        assert np.abs(np.diff(np.array(found), axis=0)).max() < 0.05
        assert found[-1] == pytest.approx(np.eye(3), abs=0.01)


def test_wrong_rows_are_refused():
    """Neighbours that are no rows are a ValueError, no fault of memory."""
    near = np.zeros((len(X), NEIGHBOURS), np.int32)
    near[0, 0] = len(X)
    with pytest.raises(ValueError, match="near"):
        _surface.gradients(X, X, near)
    with pytest.raises(ValueError, match="offset"):
        _surface.grains(X, ID, np.zeros(len(X), np.float32), np.zeros((2, 3, 3), np.float32), H, 8)
