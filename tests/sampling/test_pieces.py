"""Pieces that sheets divide snow into: their volumes, the faces between them, what is left beside sheets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from neve.fragments import find, size_classes
from neve.sampling.pressed.pieces import divide, locate, scattered
from neve.sampling.pressed.structure import LARGE, LARGER, SMALL, WIDE, planned
from neve.sampling.regions import Region, region
from neve.scene.schema.scene import Numerics, Source

SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"radius": 0.3},
    "box": {"size": (0.7, 0.5, 0.4), "rotation": (20.0, -35.0, 50.0)},
    "cylinder": {"radius": 0.1, "height": 1.2},
    "layer": {"size": (0.8, 0.7), "depth": 0.02},
    "text": {"text": "HE", "height": 0.8, "depth": 0.2},
}


def space_of(shape: str) -> Region:
    """Return the region of a source of this shape."""
    return region(Source.of(shape, **SHAPES[shape]), Numerics(dx=0.03), "sources.0")


def snow(space: Region, seed: int = 77) -> np.ndarray:
    """Return other points of the region than sheets are measured on [m] (30000, 3)."""
    return scattered(space, 30_000, np.random.default_rng(seed))


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", [0, 1])
def test_pieces_have_the_planned_volumes(shape: str, seed: int) -> None:
    """Of points that did not make the sheets as many lie in each piece as its share says.

    A share s is met within some sqrt(s / n) by the n = 300 points a piece and the 30,000 counted here, once
    for each of the log2(k) sheets that led to it: 5 of that for the largest of the deviations.
    """
    space, shares = space_of(shape), np.array([0.3, 0.02, 0.2, 0.08, 0.15, 0.05, 0.12, 0.08])
    _, piece = locate(snow(space), divide(space, shares, seed))
    found = np.sort(np.bincount(piece, minlength=len(shares))) / 30_000
    shares = np.sort(shares)
    assert (np.abs(found - shares) < 5.0 * np.sqrt(shares / (300 * len(shares)))).all()


def test_faces_lie_between_pieces() -> None:
    """Who goes from one piece to another crosses a face of both: the gaps are no longer than the way.

    Both points are bounded by the sheet that divided the last part that held both, and the distance to a
    sphere changes by no more than the way.
    """
    space = space_of("box")
    x = snow(space)
    gap, piece = locate(x, divide(space, planned(30.0), 3))
    way, near = cKDTree(x).query(x, k=12)
    apart = piece[near] != piece[:, None]
    assert apart.sum() > 10_000
    assert (np.maximum(gap[:, None], gap[near])[apart] <= way[apart] * (1 + 1e-9)).all()


def test_one_piece_has_no_faces() -> None:
    """One share, or a region that no point hits, is not divided; everything is infinitely far from sheets."""
    space = space_of("sphere")
    empty = space_of("sphere").__class__(**vars(space) | {"inside": lambda x: np.zeros(len(x), np.bool_)})
    for first in (divide(space, np.ones(1), 0), divide(empty, np.ones(4), 0)):
        gap, piece = locate(snow(space), first)
        assert np.isinf(gap).all()
        assert (piece == 0).all()


def test_gap_and_piece_depend_on_place_and_seed_alone() -> None:
    """Equal seeds give equal bits for any part of the points, others other pieces."""
    space = space_of("sphere")
    x, shares = snow(space), planned(4.2)
    gap, piece = locate(x, divide(space, shares, 5))
    again = locate(x[100:200], divide(space, shares[::-1], 5))
    assert np.array_equal(gap[100:200], again[0])
    assert np.array_equal(piece[100:200], again[1])
    assert not np.array_equal(piece, locate(x, divide(space, shares, 6))[1])


def test_plan() -> None:
    """A ball has LARGE and SMALL pieces, two balls' volume twice as many; thousands at most."""
    ball = planned(4.0 / 3.0 * np.pi)
    assert sorted(ball / ball.min()) == pytest.approx([1.0] * SMALL + [LARGER] * LARGE)
    assert ball.sum() == pytest.approx(1.0)
    assert len(planned(8.0 / 3.0 * np.pi)) == 2 * len(ball)
    assert len(planned(1e9)) <= 4000


@pytest.mark.parametrize("shape", ["sphere", "box"])
@pytest.mark.parametrize("seed", range(4))
def test_what_is_left_beside_sheets_has_three_classes_of_size(shape: str, seed: int) -> None:
    """Without simulation: what a tenth of D separates from every sheet, in half decades of mass.

    A crack opens over two cells, here of D / 10, and what an impact presses, the lowest fifth, is one lump.
    The rest, linked as fragments are, has at least two classes of 5 % of the mass besides the lump's.
    """
    space = space_of(shape)
    x = snow(space)
    deepest = space.depth(x).max()
    gap, _ = locate(x, divide(space, planned(space.volume / deepest**3), seed))
    scar = x[:, 2] < np.quantile(x[:, 2], 0.2)
    left = (gap > 0.1 * deepest) & ~scar
    one, spacing = np.ones(len(x)), (space.volume / len(x)) ** (1 / 3)
    found = find(x, np.zeros_like(x), np.where(left, 1.0, 9.0), one, one, spacing)
    classes = size_classes(found)
    assert WIDE / 2 < 0.1
    assert (classes >= 0.05).sum() >= 2, classes
