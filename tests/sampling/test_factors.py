"""Factors on stiffness, strength and density: noise, depth below the surface, height."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from neve.mpm.initial import build
from neve.sampling import fill
from neve.sampling.regions import region
from neve.scene.reading.load import scene_from
from neve.scene.schema.file_shapes import Layer, Text
from neve.scene.schema.scene import Numerics, Profile, Source, Variation

NAMES = ("stiffness", "strength", "density")
SPACING = 0.02
TURN = (20.0, -35.0, 50.0)
SHAPES: list[Source] = [
    Source.of("box", size=(0.6, 0.3, 0.2), rotation=TURN),
    Source.of("sphere", radius=0.3),
    Source.of("cylinder", radius=0.2, height=0.5, rotation=TURN),
    Source.of("layer", size=(0.6, 0.5), depth=0.3, base=1.5),
    Source.of("text", text="E", height=0.5, depth=0.2, rotation=(0.0, 30.0, 0.0)),
]
IDS = [type(shape).__name__ for shape in SHAPES]


def noisy(**amplitudes: float) -> Variation:
    """Return a variation with features small beside a box of 1 m."""
    return Variation(feature_size=0.15, **amplitudes)


@pytest.mark.parametrize("source", SHAPES, ids=IDS)
def test_depth_is_the_distance_to_the_surface(source: Source) -> None:
    """Steps shorter than the depth stay inside in any direction; longer ones leave in some direction.

    Tried with 400 directions at 300 points. One of them lies within 0.35 rad of the normal, but for a chance
    of (1 - (1 - cos 0.35) / 2)^400 = 5e-6 a point: a step of depth / cos(0.35) + tolerance must leave. The
    tolerance is two pixels of the letters' picture, 2 x spacing / 8, and nought for the other shapes. A
    layer's depth counts from its top alone.
    """
    space = region(source, Numerics(dx=2 * SPACING), "sources.0")
    rng = np.random.default_rng(0)
    points = (rng.random((20000, 3)) - 0.5) * space.size
    points = points[space.inside(points)][:300]
    assert len(points) == 300
    depth = space.depth(points)
    assert depth.min() >= 0.0
    if isinstance(source, Layer):
        assert depth == pytest.approx(0.5 * source.depth - points[:, 2], abs=1e-12)
        return
    slack = 2 * SPACING / 8 if isinstance(source, Text) else 0.0
    ways = rng.standard_normal((400, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)

    def stays(reach: np.ndarray) -> np.ndarray:
        ends = points[:, None] + reach[:, None, None] * ways
        flat = ends.reshape(-1, 3)
        within = (np.abs(flat) <= 0.5 * space.size).all(axis=1)
        held = within.copy()
        held[within] = space.inside(flat[within])
        return held.reshape(len(points), -1).all(axis=1)

    assert stays(np.maximum(depth * (1 - 1e-9) - slack, 0.0)).all()
    assert not stays(depth / np.cos(0.35) + slack + 1e-9).any()


@pytest.mark.parametrize("source", SHAPES, ids=IDS)
def test_height_counts_from_the_lowest_point(source: Source) -> None:
    """No particle is lower than the lowest point, and the lowest is within two spacings of it.

    A tilted letter touches the box around it along an edge, as the box does.
    """
    space = region(source, Numerics(dx=2 * SPACING), "sources.0")
    x = fill(source, Numerics(dx=2 * SPACING), 0).x
    assert -1e-9 <= x[:, 2].min() - space.lowest < 2 * SPACING


@pytest.mark.parametrize("by", ["depth", "height"])
def test_profile_is_piecewise_linear(by: Any) -> None:
    """Factors follow the straight lines of the table, and are constant beyond its ends."""
    table = Profile(by=by, at=(0.1, 0.2), stiffness=(4.0, 1.0), strength=(1.0, 2.0), density=(0.5, 0.5))
    source = Source.of("layer", size=(0.4, 0.4), depth=0.4, base=2.0, profile=table)
    made = fill(source, Numerics(dx=0.04), 0)
    place = made.x[:, 2] - 2.0 if by == "height" else 2.4 - made.x[:, 2]
    t = np.clip((place - 0.1) / 0.1, 0.0, 1.0)
    assert made.stiffness == pytest.approx(4.0 - 3.0 * t)
    assert made.strength == pytest.approx(1.0 + t)
    assert made.density == pytest.approx(np.full(len(t), 0.5))


def test_one_field_moves_all_factors() -> None:
    """ln factor / amplitude is the same noise for all three, density up to its mean, which is 1.

    The noise lies in [-1, 1] with median 0: in a box of some 300 features the median is nought within 0.1.
    """
    made = fill(
        Source.of("box", variation=noisy(stiffness=1.2, strength=0.3, density=0.4)), Numerics(dx=0.05), 0
    )
    noise = np.log(made.stiffness) / 1.2
    assert noise.min() >= -1.0
    assert noise.max() <= 1.0
    assert np.ptp(noise) > 1.0
    assert abs(np.median(noise)) < 0.1
    assert np.log(made.strength) / 0.3 == pytest.approx(noise)
    assert np.ptp(np.log(made.density) - 0.4 * noise) < 1e-12
    assert made.density.mean() == pytest.approx(1.0, abs=1e-12)


def test_amplitudes_do_not_disturb_each_other() -> None:
    """Stiffness is the same to the bit with other amplitudes beside it; no amplitude is a factor of 1."""
    alone = fill(Source.of("box", variation=noisy(stiffness=0.5)), Numerics(), 0)
    both = fill(Source.of("box", variation=noisy(stiffness=0.5, strength=0.2, density=0.3)), Numerics(), 0)
    assert np.array_equal(alone.stiffness, both.stiffness)
    for made in (
        alone,
        fill(Source.of("box", variation=noisy()), Numerics(), 0),
        fill(Source.of("box"), Numerics(), 0),
    ):
        assert np.array_equal(np.unique(made.density), [1.0])
        assert np.array_equal(np.unique(made.strength), [1.0])


def test_noise_and_profile_multiply() -> None:
    """The factor with both is the product of the factors with each."""
    profile = Profile(at=(0.0, 0.1), stiffness=(3.0, 1.0), density=(1.5, 1.0))
    variation = noisy(stiffness=0.5, density=0.2)
    both = fill(Source.of("box", variation=variation, profile=profile), Numerics(), 0)
    first, second = (
        fill(Source.of("box", **one), Numerics(), 0)
        for one in ({"variation": variation}, {"profile": profile})
    )
    for name in NAMES:
        assert getattr(both, name) == pytest.approx(getattr(first, name) * getattr(second, name))


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_state_holds_the_factors(precision: str) -> None:
    """m = rho0 f V0, and the columns are the factors, to rounding; noise in density keeps the mass."""
    tables: dict[str, Any] = {
        "numerics": {"dx": 0.1, "precision": precision},
        "snow": {"rho0": 300.0},
        "sources": [
            {"shape": "box", "variation": {"stiffness": 0.5, "strength": 0.3, "density": 0.4}},
            {"shape": "sphere", "center": [3.0, 0.0, 1.0], "snow": {"rho0": 200.0}},
        ],
    }
    scene = scene_from(tables)
    _, state, _ = build(scene)
    box = fill(scene.sources[0], scene.numerics, 0)
    rows = slice(0, len(box.x))
    eps = float(np.finfo(precision).eps)
    for name in ("stiffness", "strength"):
        assert np.asarray(getattr(state, name))[rows] == pytest.approx(getattr(box, name), rel=2 * eps)
        assert np.array_equal(np.unique(np.asarray(getattr(state, name))[rows.stop :]), [1.0])
    m, V0 = np.asarray(state.m, float), np.asarray(state.V0, float)
    assert m[rows] == pytest.approx(300.0 * box.density * box.volume, rel=2 * eps)
    assert m[rows].sum() == pytest.approx(300.0 * 1.0, rel=4 * eps)
    assert m[rows.stop :] == pytest.approx(200.0 * V0[rows.stop :], rel=2 * eps)
