"""How many boxes of its tree a line is held against, and how deep the tree is, whatever the triangles."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
from device.compiled import library

from neve.geometry.heights import triangulated

BY_AREA = 40
"""Levels that `bvh.hpp` splits by area; what is left there is halved down to leaves of four."""
RNG = np.random.default_rng


@pytest.fixture(scope="module")
def boxes_met(tmp_path_factory):
    """Return (boxes that each line is held against, depth) of triangles (n, 3, 3) and lines (m, 2, 3)."""
    compiled = library(Path(__file__).with_name("boxes.cpp"), tmp_path_factory.mktemp("boxes"))

    def of(triangles, lines):
        corners, line = (np.ascontiguousarray(a, float) for a in (triangles, lines))
        met = np.zeros(len(line), np.int32)
        at = [a.ctypes.data_as(ctypes.c_void_p) for a in (corners, line, met)]
        depth = compiled.boxes_met(len(corners), at[0], len(line), at[1], at[2])
        assert depth >= 0, "each triangle is in one leaf, within its box"
        assert depth <= BY_AREA + np.ceil(np.log2(len(corners)))
        return met, depth

    return of


def hills(samples=81, rim=0.0):
    """A terrain of 10 m by 10 m as triangles (n, 3, 3), with a rim of slivers around it."""
    x = np.linspace(-5, 5, samples)
    z = 0.3 * np.sin(3 * x)[:, None] * np.cos(2 * x) + 0.1 * np.sin(17 * x[:, None] + 5 * x)
    if rim > 0:
        x, z = np.concatenate([[-5 - rim], x, [5 + rim]]), np.pad(z, 1, mode="edge")
    corners, faces = triangulated(x, x, z)
    return corners[faces]


def upright(count=200):
    """Lines along z over the terrain."""
    lines = np.zeros((count, 2, 3))
    lines[:, 0, :2] = RNG(1).uniform(-4.9, 4.9, (count, 2))
    lines[:, 1, 2] = 1
    return lines


def slivers(count, axis, length, seed=2):
    """Triangles 1 cm wide along an axis, anywhere over the terrain."""
    middle = RNG(seed).uniform(-5, 5, (count, 3)) * (1, 1, 0.1)
    along = np.zeros(3)
    along[axis] = length / 2
    return np.stack([middle - along, middle + along, middle + along + 0.01], axis=1)


@pytest.mark.parametrize("turn", [0, 1, 2])
def test_a_rim_of_slivers_hides_no_terrain(boxes_met, turn):
    """Slivers of 40 m by 12 cm: what they surround is as soon found as alone, but for the way through them.

    The tree splits them off by one axis and by the other, and what is left is the terrain's own tree. The two
    trees of slivers are rows: a line beside their ends meets no more boxes of both than of the terrain.
    """
    alone, _ = boxes_met(hills(), upright())
    met, _ = boxes_met(np.roll(hills(rim=40.0), turn, axis=2), np.roll(upright(), turn, axis=2))
    assert (met - alone).max() <= alone.max()
    assert met.mean() <= 2 * alone.mean()


@pytest.mark.parametrize("below", [1, 4], ids=["one", "as many as a leaf holds"])
def test_giants_cost_two_boxes(boxes_met, below):
    """A root and a leaf for triangles that are far larger than all else; the rest is the same tree."""
    giants = np.array([[[-500.0, -500, -3], [900, -400, -3], [0, 900, -3]]]) - np.arange(below)[:, None, None]
    alone, depth = boxes_met(hills(), upright())
    met, deeper = boxes_met(np.concatenate([hills(), giants]), upright())
    np.testing.assert_array_equal(met, alone + 2)
    assert deeper == depth + 1


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_slivers_along_an_axis(boxes_met, axis):
    """One sliver of 6 m to 128 triangles of hills: half as many boxes more than without, on average."""
    alone, _ = boxes_met(hills(), upright())
    met, _ = boxes_met(np.concatenate([hills(), slivers(100, axis, 6.0)]), upright())
    assert met.mean() <= 1.5 * alone.mean()


def nested(sizes):
    """A triangle of each size, all with a corner at zero."""
    return np.asarray(sizes)[:, None, None] * np.array([[0.0, 0, 0], [1, 0, 0.1], [0, 1, 0]])


@pytest.mark.parametrize(
    "triangles",
    [
        nested(0.8 ** np.arange(1500)),
        nested(0.2 ** np.arange(400)),
        nested(np.repeat([1.0, 1e-3], [50, 5000])),
        nested(np.ones(4000)),
        hills(41) * (1e4, 1, 1),
        np.concatenate([hills(41) * scale for scale in (1.0, 1e-2, 1e-4)]),
        RNG(3).uniform(-1, 1, (4000, 3, 3)) ** 9,
        np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]]),
    ],
    ids=["scales", "far scales", "two scales", "all equal", "long and thin", "hills in hills", "soup", "one"],
)
def test_depth_is_bounded(boxes_met, triangles):
    """No stack of a walk overflows (`deepest`, 96): 40 levels, then halves; held in the fixture."""
    _, depth = boxes_met(triangles, upright(1))
    assert depth < 96
