"""`structure = "chunks"`: lumps, shells, equal masses and weak sheets, all in proportion to the source."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from neve.sampling import fill
from neve.sampling.pressed.structure import PACKED, SMOOTH_RIM, STIFFER, STRONGER, WEAK_STRENGTH, chunks
from neve.sampling.regions import region
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Numerics, Source

SHAPES: dict[str, dict[str, Any]] = {
    "sphere": {"radius": 0.3},
    "box": {"size": (0.7, 0.5, 0.4), "rotation": (20.0, -35.0, 50.0)},
    "cylinder": {"radius": 0.3, "height": 0.6},
    "layer": {"size": (0.8, 0.7), "depth": 0.3},
    "text": {"text": "E", "height": 0.8, "depth": 0.2},
}


def source(shape: str, **keys: Any) -> Source:
    """Return a source of chunks."""
    return Source.of(shape, structure="chunks", **SHAPES[shape] | keys)


def depths(shape: str, x: np.ndarray, dx: float) -> np.ndarray:
    """Return the depth of points `x` in the world below the surface of the shape [m] (n,)."""
    space = region(source(shape), Numerics(dx=dx), "sources.0")
    return space.depth((x - space.center) @ space.rotation - space.middle)


@pytest.mark.parametrize("shape", SHAPES)
def test_outline_keeps_the_inside_and_roughens_the_rim(shape: str) -> None:
    """All of what is deeper than the rim stays but for the thinning; of the rim, lumps hold a part.

    The thinning keeps the share exp(-PACKED d / D), never less than exp(-PACKED) = 0.78.
    """
    dx = 0.03
    plain = fill(Source.of(shape, **SHAPES[shape]), Numerics(dx=dx), 0)
    made = fill(source(shape), Numerics(dx=dx), 0)
    all_depths = depths(shape, plain.x, dx)
    deepest = all_depths.max()
    edges = np.array([0.0, SMOOTH_RIM, 0.3, 0.6, 1.0 + 1e-9]) * deepest
    kept = np.histogram(depths(shape, made.x, dx), edges)[0] / np.histogram(all_depths, edges)[0]
    assert 0.1 < kept[0] < 0.97
    middle = np.exp(-PACKED * 0.5 * (edges[1:-1] + edges[2:]) / deepest)
    np.testing.assert_allclose(kept[1:], middle, atol=0.08)


@pytest.mark.parametrize("shape", SHAPES)
def test_particles_have_equal_masses_that_add_up(shape: str) -> None:
    """m ~ density volume is the same for all; their sum is that of the volume that the outline holds."""
    dx = 0.03
    made = fill(source(shape), Numerics(dx=dx), 0)
    mass = made.density * made.volume
    np.testing.assert_allclose(mass, mass[0], rtol=1e-12)
    assert mass.sum() == pytest.approx(made.volume.sum(), rel=0.02)
    plain = fill(Source.of(shape, **SHAPES[shape]), Numerics(dx=dx), 0).volume.sum()
    assert 0.75 * plain < made.volume.sum() < plain


def test_shells_and_sheets() -> None:
    """Beside sheets stiffness is exp(STIFFER (1 - d / D)), strength alike; in them it falls by exp(-5)."""
    ball = source("sphere")
    made = fill(ball, Numerics(dx=0.02), 0)
    depth = 0.3 - np.linalg.norm(made.x - np.array(ball.place), axis=1)
    rind = 1.0 - depth / 0.3
    shell, weak = np.exp(STIFFER * rind), made.strength / np.exp(STRONGER * rind)
    beside = weak > 0.98
    assert 0.5 < beside.mean() < 0.8
    assert weak.min() == pytest.approx(np.exp(-WEAK_STRENGTH), rel=0.02)
    np.testing.assert_allclose(made.stiffness[beside], shell[beside], rtol=0.05)
    assert (made.stiffness[~beside] < np.exp(STIFFER)).all()
    assert made.density.max() / made.density.min() == pytest.approx(np.exp(PACKED), rel=0.05)


def test_twice_as_large_is_twice_as_large() -> None:
    """A source of twice the size, in cells of twice the size, has the same factors at places twice as far."""
    small = fill(source("sphere"), Numerics(dx=0.03), 0)
    large = fill(source("sphere", radius=0.6), Numerics(dx=0.06), 0)
    for name in ("stiffness", "strength", "density"):
        np.testing.assert_allclose(getattr(large, name), getattr(small, name), rtol=1e-9)
    np.testing.assert_allclose(large.volume, 8 * small.volume, rtol=1e-9)


def test_seeds_make_other_snow_and_the_place_decides() -> None:
    """Equal seeds give equal bits, others other sheets; which do not depend on the other particles."""
    space = region(source("sphere"), Numerics(), "sources.0")
    x = 0.2 * (np.random.default_rng(0).random((3000, 3)) - 0.5)
    x = np.concatenate([np.zeros((1, 3)), x])
    one, again, other = (chunks(space, x, seed) for seed in (1, 1, 2))
    for a, b in zip(one, again, strict=True):
        assert np.array_equal(a, b)
    assert np.array_equal(chunks(space, x[:500], 1).strength, one.strength[:500])
    assert not np.array_equal(other.strength, one.strength)


def test_scene_takes_the_structure_of_its_kind() -> None:
    """A source without a word of its own has the structure of its snow's kind; "plain" undoes it."""
    tables = {
        "snow": {"kind": "packed"},
        "sources": [{"shape": "box"}, {"shape": "box", "structure": "plain"}],
    }
    scene = scene_from(tables)
    assert [scene.completed(s).structure for s in scene.sources] == ["chunks", "plain"]
