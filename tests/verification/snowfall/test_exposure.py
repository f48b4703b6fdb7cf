"""How much of the falling snow reaches a place: METHODS' tests of exposure, and the books."""

import math

import numpy as np
import pytest
from verification.snowfall.surfaces import box, columns_of, counted, ground, places, plate

from neve import _core
from neve.snowfall.cover import Raster

HEIGHT, FLUTTER = 3.0, 0.3
"""Of a roof [m], and of flakes [m over 1 m]."""


def spread(height, flutter):
    """Deviation of the sideways way of a flake at a height: whole pieces, and a share u of the next.

    Var = flutter^2 (sum of the heights of whole pieces + u^2 times that of the next).
    """
    core, risen, total = _core.snowfall, 0.0, 0.0
    while True:
        piece = max(core.shortest_piece, core.piece_growth * risen)
        if risen + piece >= height:
            share = (height - risen) / piece
            return flutter * math.sqrt(total + share * share * piece)
        risen, total = risen + piece, total + piece


def half_roof(x, s):
    """Share of the snow that falls x [m] before the edge of a roof: erfc(-x / (sqrt(2) s)) / 2."""
    return np.array([0.5 * math.erfc(-v / (math.sqrt(2.0) * s)) for v in x])


def under_a_half_roof(tolerance, detail, seed=0):
    """The share on the ground below a roof over x < 0, and what it should be."""
    s = spread(HEIGHT, FLUTTER)
    raster = Raster.over((0.0, 0.0), (8.0 * s, 2.0), 0.05)
    roof = plate("roof", "sheet", -100.0, 0.0, -100.0, 100.0, HEIGHT)
    columns, share, error, bucket = counted(
        [ground(), roof], raster, FLUTTER, seed=seed, tolerance=tolerance, detail=detail
    )
    is_ground = columns.part() == 0
    x, _ = places(columns, raster)
    return share[is_ground], half_roof(x[is_ground], s), error[is_ground], bucket[is_ground]


def test_open_ground_gets_all():
    """Level ground under the sky gets the rate, exactly: no flake is in doubt."""
    _, share, _, _ = counted([ground()], Raster.over((0.0, 0.0), (3.0, 2.0), 0.1), 0.5)
    assert np.all(share == 1.0)


def test_edge_of_a_roof():
    """Under the edge of a half-plane the share is half an erfc of the spread at the height of the roof.

    Each place within 4 standard errors and the difference that a bucket may hide, twice the detail; their
    sum, which hides nothing, within 4 standard errors of its own: a bucket of m places is one count.
    """
    share, exact, error, bucket = under_a_half_roof(0.02, 0.05)
    assert np.all(np.abs(share - exact) <= 4 * 0.02 + 2 * 0.05)
    deviation = math.sqrt(float(np.sum(error**2 * bucket.astype(float) ** 2)))
    assert abs(float(np.sum(share - exact))) <= 4 * deviation


def test_more_flakes_are_nearer():
    """The root mean square error follows the tolerance as it is halved twice."""
    errors = []
    for tolerance in (0.04, 0.02, 0.01):
        share, exact, _, _ = under_a_half_roof(tolerance, 2 * tolerance)
        errors.append(math.sqrt(float(np.mean((share - exact) ** 2))))
    assert all(error <= 1.5 * t for error, t in zip(errors, (0.04, 0.02, 0.01), strict=True))
    assert errors[2] < 0.4 * errors[0]


def test_no_flutter_no_snow_below_a_roof():
    """Without flutter and wind what is covered gets nothing, and the rest all."""
    raster = Raster.over((0.0, 0.0), (4.0, 4.0), 0.1)
    columns, share, _, _ = counted(
        [ground(), plate("roof", "sheet", -1.0, 1.0, -1.0, 1.0, 2.0)], raster, tolerance=0.02
    )
    x, y = places(columns, raster)
    is_below = (columns.part() == 0) & (np.abs(x) < 1.0) & (np.abs(y) < 1.0)
    assert is_below.sum() == 400
    assert np.all(share[is_below & (np.abs(x) < 0.9) & (np.abs(y) < 0.9)] == 0.0)
    assert np.all(share[columns.part() == 1] == 1.0)


@pytest.mark.parametrize("cells", [2, 3, 4, 12])
def test_places_in_one_quarter_of_a_bucket_differ(cells):
    """Small grounds, and the corner of a larger one, fill a quarter of a bucket: a roof still covers exactly.

    The first bucket has 8 by 8 cells; all rows are below the roof but the last.
    """
    raster = Raster.over((0.0, 0.0), (0.1 * cells, 0.1 * cells), 0.1)
    edge = 0.05 * cells - 0.1
    columns, share, _, _ = counted([ground(), plate("roof", "sheet", -50.0, edge, -50.0, 50.0, 2.0)], raster)
    x, _ = places(columns, raster)
    is_ground = columns.part() == 0
    assert is_ground.sum() == cells**2
    assert np.array_equal(share[is_ground], np.where(x[is_ground] < edge, 0.0, 1.0))


@pytest.mark.parametrize("below", ["34", "123456", "2345", "0145", "0246"])
def test_places_differ_where_quarters_are_alike(below):
    """Rails over some of the eight columns of each bucket: its quarters get as much, its places do not."""
    raster = Raster.over((0.8, 0.8), (1.6, 1.6), 0.1)
    columns_below = [i for i in range(16) if str(i % 8) in below]
    rails = [plate(f"{i}", "sheet", 0.1 * i, 0.1 * (i + 1), -50.0, 50.0, 2.0) for i in columns_below]
    columns, share, _, _ = counted([ground(), *rails], raster)
    is_ground = columns.part() == 0
    is_below = np.isin(columns.column()[is_ground] // raster.ny, columns_below)
    assert np.array_equal(share[is_ground], np.where(is_below, 0.0, 1.0))


def test_nothing_lies_below_a_board_that_hangs_together_with_the_slope():
    """Cells of 0.5 m: the top of a board is here and there as high over the slope as an edge may be."""
    raster = Raster.over((0.0, 0.0), (8.0, 4.0), 0.5)
    board = box((0.0, -2.0, 2.0), (2.0, 2.0, 2.1), "board")
    columns, share, _, _ = counted([ground(0.0, (0.1, -0.05)), board], raster)
    x, _ = places(columns, raster)
    is_below = (columns.part() == 0) & (x > 0.0) & (x < 2.0)
    assert is_below.sum() == 32
    assert np.all(share[is_below] == 0.0)
    assert np.all(share[~is_below] == 1.0)


def test_wind_moves_the_shadow():
    """In a wind w the shadow of a roof at height H lies H w / v downwind."""
    raster = Raster.over((0.0, 0.0), (8.0, 1.0), 0.05)
    columns, share, _, _ = counted(
        [ground(), plate("roof", "sheet", -1.0, 1.0, -50.0, 50.0, 2.0)], raster, wind=(0.75, 0.0), detail=0.02
    )
    x, _ = places(columns, raster)
    low = columns.part() == 0
    assert np.all(share[low & (x > 0.51) & (x < 2.49)] < 0.03)
    assert np.all(share[low & ((x < 0.49) | (x > 2.51))] > 0.97)


@pytest.mark.parametrize("wind", [0.0, 0.5, -0.5])
def test_slopes_against_the_wind_get_more(wind):
    """A plane of slope g gets 1 - g w / v over each unit of its area seen from above: the flux through it."""
    raster = Raster.over((0.0, 0.0), (1.0, 1.0), 0.1)
    _, share, _, _ = counted([ground(slope=(0.4, 0.0))], raster, wind=(wind, 0.0))
    assert np.abs(share - (1.0 + 0.4 * wind)).max() < 1e-12


def test_what_a_roof_keeps_lies_on_it():
    """Sums over roof and ground are the sky's: what the ground lacks is on the roof, within 4 errors."""
    raster = Raster.over((0.0, 0.0), (8.0, 8.0), 0.1)
    columns, share, error, bucket = counted(
        [ground(), plate("roof", "sheet", -0.95, 0.95, -0.95, 0.95, 1.5)], raster, 0.3
    )
    deviation = math.sqrt(float(np.sum(error**2 * bucket.astype(float) ** 2)))
    assert abs(float(share.sum()) - raster.nx * raster.ny) <= 4 * deviation
    assert (columns.part() == 1).sum() == 19 * 19


def test_same_bits_for_any_threads():
    """No sum follows the schedule; another seed counts other flakes."""
    raster = Raster.over((0.0, 0.0), (4.0, 4.0), 0.1)
    pieces = [ground(), box((-1, -1, 0), (0.5, 0.5, 1)), plate("roof", "sheet", -1, 2, -1, 2, 2.0)]
    before = _core.threads()
    found = []
    for threads in (1, 2, 5):
        _core.set_threads(threads)
        found.append(counted(pieces, raster, 0.3)[1])
    _core.set_threads(before)
    assert all(np.array_equal(found[0], other) for other in found[1:])
    assert not np.array_equal(found[0], counted(pieces, raster, 0.3, seed=1)[1])


def test_places_of_stacked_bodies():
    """A box on the ground and two that cut each other over it: each surface under open space is a place."""
    raster = Raster.over((0.5, 0.5), (1.0, 1.0), 1.0)
    columns, _ = columns_of(
        [ground(), box((0, 0, 0), (1, 1, 1)), box((0, 0, 2), (1, 1, 3)), box((0, 0, 2.5), (1, 1, 4))], raster
    )
    assert columns.z().tolist() == [4.0, 1.0]
    assert columns.ceiling().tolist() == [np.inf, 2.0]
