"""Which snow stays: METHODS' tests of stability, edges, and volumes."""

import math

import numpy as np
import pytest
from verification.snowfall.surfaces import box, columns_of, ground, places, plate

from neve import _core
from neve.snowfall.cover import Raster

TAN = math.tan(math.radians(40.0))


def slid(columns, depth, repose=TAN, holding_depth=False, passes=5000):
    """Depth at rest and sums."""
    return _core.snowfall.slide(
        columns=columns,
        depth=np.ascontiguousarray(depth, np.float64),
        repose=repose,
        holding_depth=holding_depth,
        least_slope=math.tan(math.radians(25.0)),
        gravity=9.81,
        passes=passes,
    )


def steepest(columns, depth, cell):
    """Largest angle between the tops of places side by side, the higher one covered [degrees]."""
    top = columns.z() + depth
    near = columns.joined(top)
    found = [0.0]
    for k in range(4):
        here = np.flatnonzero((near[:, k] >= 0) & (depth > 1e-6))
        found.append(float(np.max((top[here] - top[near[here, k]]) / cell, initial=0.0)))
    return math.degrees(math.atan(max(found)))


def test_block_becomes_a_triangle():
    """A block 2a wide and H high becomes a triangle of base B = sqrt(8 a H / tan), height B tan / 2."""
    cell, a, height = 0.02, 0.3, 0.8
    raster = Raster((-2.0, 0.0), cell, 200, 1)
    columns, _ = columns_of([ground()], raster)
    x, _ = places(columns, raster)
    depth, sums = slid(columns, np.where(np.abs(x) < a, height, 0.0))
    base = math.sqrt(8 * a * height / TAN)
    exact = np.maximum((0.5 * base - np.abs(x)) * TAN, 0.0)
    assert sums["settled"]
    assert abs(depth.max() - 0.5 * base * TAN) <= cell
    assert np.abs(depth - exact).max() <= cell * TAN + cell
    assert abs(depth.sum() * cell - 2 * a * height) < 1e-12


def test_point_becomes_a_cone():
    """Snow poured on one place becomes a heap as steep as repose, h^3 = 3 V tan^2 / pi for a round one.

    Eight ways are eight sides: of a pyramid on a regular octagon, of inner radius r, the volume is
    8 tan(pi/8) r^2 h / 3.
    """
    cell, volume = 0.05, 0.4
    raster = Raster.over((0.0, 0.0), (4.05, 4.05), cell)
    columns, _ = columns_of([ground()], raster)
    depth = np.zeros(len(columns))
    depth[len(depth) // 2] = volume / cell**2
    depth, sums = slid(columns, depth)
    assert sums["settled"]
    exact = (3 * volume * TAN**2 / (8 * math.tan(math.pi / 8))) ** (1 / 3)
    assert abs(depth.max() - exact) <= cell
    assert abs(depth.sum() * cell**2 - volume) < 1e-9 * volume
    assert steepest(columns, depth, cell) <= 40.1


def test_snow_on_rough_ground_is_no_steeper_than_repose():
    """On hills, after a deep fall, covered slopes are at most the angle of repose and 0.1 degrees."""
    cell, n = 0.1, 64
    raster = Raster((0.0, 0.0), cell, n, n)
    axis = np.linspace(-0.5, n * cell + 0.5, 90)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    z = 0.8 * np.sin(2.3 * x) * np.cos(1.7 * y)
    i = np.arange(90 * 90).reshape(90, 90)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)
    piece = ("hills", "ground", np.column_stack([x.ravel(), y.ravel(), z.ravel()]), faces)
    columns, _ = columns_of([piece], raster)
    rng = np.random.default_rng(1)
    depth, sums = slid(columns, fell := 0.1 + 0.3 * rng.random(len(columns)))
    assert sums["settled"]
    assert sums["moved"] > 0
    assert abs(depth.sum() - fell.sum()) <= 1e-9 * fell.sum()
    assert steepest(columns, depth, cell) <= 40.1
    again, _ = slid(columns, fell)
    assert np.array_equal(depth, again)


def test_what_slides_over_an_edge_lands_below():
    """A steep roof sheds its snow onto the ground, some of it beyond the eave, and none is lost."""
    raster = Raster((-5.0, 0.0), 0.05, 200, 1)
    roof = plate("roof", "sheet", -1.0, 1.0, -9.0, 9.0, 3.0, slope=(-1.6, 0.0))
    columns, _ = columns_of([ground(), roof], raster)
    is_roof = columns.part() == 1
    fell = np.where(is_roof, 0.2, 0.0)
    depth, sums = slid(columns, fell)
    x, _ = places(columns, raster)
    assert sums["lost"] == 0.0
    assert abs(depth.sum() - fell.sum()) <= 1e-9 * fell.sum()
    assert depth[is_roof].sum() < 0.02 * fell.sum()
    landed = np.sum((x * depth)[~is_roof]) / depth[~is_roof].sum()
    assert landed > 1.2, "it flies on with the speed of its slide"
    assert steepest(columns, depth, 0.05) <= 40.1


def test_a_wall_holds_and_a_void_takes():
    """Between walls snow stays; where nothing is below an edge, what is too steep is lost, and counted."""
    raster = Raster.over((0.0, 0.0), (1.0, 1.0), 0.05)
    pit = [
        plate("floor", "sheet", -0.5, 0.5, -0.5, 0.5, 0.0),
        box((-0.7, -0.7, -0.5), (-0.5, 0.7, 2.0)),
        box((0.5, -0.7, -0.5), (0.7, 0.7, 2.0)),
    ]
    columns, _ = columns_of(pit, raster)
    fell = np.full(len(columns), 0.5)
    depth, sums = slid(columns, fell)
    assert sums["lost"] == 0.0
    assert np.array_equal(depth, fell)
    wide = Raster.over((0.0, 0.0), (2.0, 1.0), 0.05)
    columns, _ = columns_of(pit[:1], wide)
    fell = np.full(len(columns), 0.5)
    depth, sums = slid(columns, fell)
    assert sums["lost"] > 0.0
    assert abs(depth.sum() + sums["lost"] - fell.sum()) <= 1e-9 * fell.sum()
    assert steepest(columns, depth, 0.05) <= 40.1


@pytest.mark.parametrize("angle", [35.0, 45.0])
def test_slopes_hold_so_much(angle):
    """SnowSlide: a slope of beta degrees keeps 3178 beta^-1.998 m, but for its foot, where all gathers."""
    raster = Raster((0.0, 0.0), 1.0, 40, 3)
    columns, _ = columns_of([ground(slope=(-math.tan(math.radians(angle)), 0.0))], raster)
    depth, _ = slid(columns, np.full(len(columns), 4.0), holding_depth=True)
    held = 3178.0 * angle**-1.998
    by_row = depth.reshape(40, 3)
    assert np.allclose(by_row[:22], held, rtol=1e-6)
    assert abs(depth.sum() - 4.0 * len(columns)) < 1e-6
