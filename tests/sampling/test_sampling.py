"""Particles of every shape: volumes, counts, evenness, least distance, motion, seeds, letters."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from neve.sampling import fill
from neve.sampling.points import TILE, poisson, poisson_tile, regular, touching_tiles
from neve.scene.errors import SceneError
from neve.scene.schema.scene import Numerics, Source, Variation

SHAPES: list[tuple[Source, float]] = [
    (Source.of("box", size=(1.0, 0.7, 0.5), rotation=(10.0, 20.0, 30.0)), 0.35),
    (Source.of("sphere", radius=0.5), 4 / 3 * pi * 0.125),
    (Source.of("cylinder", radius=0.4, height=0.9, rotation=(0.0, 90.0, 0.0)), pi * 0.16 * 0.9),
    (Source.of("layer", size=(2.0, 1.0), depth=0.2), 0.4),
]
IDS = ["box", "sphere", "cylinder", "layer"]
RANDOM: list[Any] = ["jittered", "poisson"]
SAMPLINGS: list[Any] = [*RANDOM, "regular"]


def least_distance(x: np.ndarray, limit: float) -> float:
    """Return the least distance between two of the points `x`, or infinity if it is larger than `limit`.

    Sorts the points into cells of edge `limit` and compares each with those of the 27 cells around it.
    """
    cell = np.floor((x - x.min(axis=0)) / limit).astype(np.int64) + 1
    size = cell.max(axis=0) + 2
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    x, key = x[order], key[order]
    least = np.inf
    for shift in np.ndindex(3, 3, 3):
        other = key + ((shift[0] - 1) * size[1] + shift[1] - 1) * size[2] + shift[2] - 1
        begin, end = np.searchsorted(key, other), np.searchsorted(key, other, side="right")
        for k in range(int((end - begin).max())):
            mine = np.flatnonzero((begin + k < end) & (begin + k != np.arange(len(x))))
            if len(mine):
                least = min(least, float(np.linalg.norm(x[mine] - x[begin[mine] + k], axis=1).min()))
    return least if least <= limit else np.inf


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize(("source", "volume"), SHAPES, ids=IDS)
def test_volume_and_count(source: Source, volume: float, sampling: Any) -> None:
    """The particles' volumes add up to the shape's, and n = 8 V / dx^3 within 5 % (rounding at surfaces)."""
    numerics = Numerics(dx=0.04, sampling=sampling)
    samples = fill(source, numerics, 0)
    assert samples.volume.sum() == pytest.approx(volume, rel=1e-12)
    assert np.ptp(samples.volume) == 0.0
    assert len(samples.x) == pytest.approx(volume * 8 / numerics.dx**3, rel=0.05)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("per_cell", [1, 5, 8, 27])
def test_particles_per_cell(per_cell: int, sampling: Any) -> None:
    """Any number of particles per cell is met, a cube number or not."""
    samples = fill(Source.of("box"), Numerics(dx=0.05, particles_per_cell=per_cell, sampling=sampling), 0)
    assert len(samples.x) == pytest.approx(8000 * per_cell, rel=0.03)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_points_are_inside_and_fill_the_shape(sampling: Any) -> None:
    """All lie inside; mean and variance are those of a uniform ball, the centre and r^2 / 5 along an axis."""
    ball = Source.of("sphere", center=(3.0, -2.0, 1.0), radius=0.5)
    x = fill(ball, Numerics(dx=0.03, sampling=sampling), 0).x - ball.center
    assert np.linalg.norm(x, axis=1).max() <= 0.5
    assert np.abs(x.mean(axis=0)).max() < 2e-3
    assert x.var(axis=0) == pytest.approx(np.full(3, 0.05), rel=0.01)


def test_rotated_shapes_are_where_they_should_be() -> None:
    """A rod along x turned by 90 degrees about z lies along y; a cylinder about y lies along x."""
    rod = fill(
        Source.of("box", center=(5.0, 0.0, 0.0), size=(2.0, 0.2, 0.2), rotation=(0.0, 0.0, 90.0)),
        Numerics(),
        0,
    ).x
    assert np.abs(rod - [5.0, 0.0, 0.0]).max(axis=0) == pytest.approx([0.1, 1.0, 0.1], abs=0.03)
    roll = fill(
        Source.of("cylinder", center=(0, 0, 0), radius=0.2, height=2, rotation=(0, 90, 0)), Numerics(), 0
    ).x
    assert np.abs(roll).max(axis=0) == pytest.approx([1.0, 0.2, 0.2], abs=0.03)
    assert np.hypot(roll[:, 1], roll[:, 2]).max() <= 0.2
    layer = fill(Source.of("layer", center=(1.0, 2.0), size=(2.0, 1.0), depth=0.2, base=0.3), Numerics(), 0).x
    assert layer.min(axis=0) == pytest.approx([0.0, 1.5, 0.3], abs=0.02)
    assert layer.max(axis=0) == pytest.approx([2.0, 2.5, 0.5], abs=0.02)


@pytest.mark.parametrize(("sampling", "least"), [("jittered", 0.3), ("poisson", 0.83)])
def test_least_distance(sampling: Any, least: float) -> None:
    """No two particles are nearer than 0.3 (jittered) or 0.83 (Poisson) lattice spacings, over many tiles."""
    numerics = Numerics(dx=0.06, sampling=sampling)
    x = fill(Source.of("box", size=(1.4, 1.3, 1.2)), numerics, 0).x
    spacing = 0.06 / 2.0
    assert spacing * least <= least_distance(x, spacing)


def test_regular_is_a_lattice() -> None:
    """Eight particles a cell stand at (i + 1/2) dx / 2 from the faces, whatever the seed: float rounding."""
    box = Source.of("box", center=(0.0, 0.0, 0.0), size=(0.4, 0.2, 0.1))
    x = fill(box, Numerics(dx=0.1, sampling="regular", seed=3), 0).x
    assert x == pytest.approx(regular(np.array(box.size), 0.05), abs=1e-15)
    for axis, size in enumerate(box.size):
        steps = np.unique(np.round((x[:, axis] + 0.5 * size) / 0.05 - 0.5, 9))
        assert np.array_equal(steps, np.arange(round(size / 0.05)))
    assert len(x) == 8 * 4 * 2


@pytest.mark.parametrize("size", [(300.0, 300.0, 0.1), (9000.0, 0.1, 0.1), (20.0, 20.0, 20.0)])
def test_tiles_grow_with_the_box(size: tuple[float, float, float]) -> None:
    """A turned sheet or rod asks for tiles along itself, not for those of the cube around it."""
    c, s = np.cos(0.7), np.sin(0.7)
    axes = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    shift = np.array([0.3, 0.6, 0.9])
    tiles = touching_tiles(np.array(size), 1.0, axes, shift)
    assert len(tiles) <= 27 * np.prod(np.ceil(size))
    assert len(np.unique(tiles, axis=0)) == len(tiles)
    points = (np.random.default_rng(1).random((2000, 3)) - 0.5) * size
    hit = np.unique(np.floor(points @ axes - shift).astype(np.int64), axis=0)
    assert {tuple(tile) for tile in hit} <= {tuple(tile) for tile in tiles}


def test_poisson_fills_a_thin_sheet() -> None:
    """A sheet of a tenth of a tile's thickness holds one point in spacing^3, as any box does."""
    size = np.array([120.0, 90.0, 2.0])
    x = poisson(size, 1.0, np.random.default_rng(4), 4)
    assert len(x) == pytest.approx(np.prod(size), rel=0.05)


def test_poisson_tile_is_periodic_and_full() -> None:
    """No two points are nearer than 1, across the tile's faces too; hardly any room for another is left."""
    tile = poisson_tile(3)
    images = np.concatenate([tile + TILE * np.array(s) for s in np.ndindex(2, 2, 2)])
    assert least_distance(images, 1.2) >= 1.0
    assert 0.58 < len(tile) / TILE**3 < 0.74, "below the saturation of random sequential packing"
    darts = np.random.default_rng(0).uniform(0, TILE, (2000, 3))
    gaps = np.abs(darts[:, None] - tile[None])
    gaps = np.minimum(gaps, TILE - gaps)
    free = np.sqrt((gaps**2).sum(axis=-1)).min(axis=1) > 1.0
    assert free.mean() < 0.02


@pytest.mark.parametrize(("sampling", "spread"), [("jittered", 0.3), ("poisson", 0.3)])
def test_density_is_even(sampling: Any, spread: float) -> None:
    """Particles in cells of dx^3 vary by less than 0.3 of the mean; independent points would vary by 0.35."""
    x = fill(Source.of("box", center=(0, 0, 0), size=(2, 2, 2)), Numerics(dx=0.1, sampling=sampling), 0).x
    counts, _ = np.histogramdd(x, bins=[np.linspace(-0.95, 0.95, 20)] * 3)
    assert counts.mean() == pytest.approx(8.0, rel=0.02)
    assert counts.std() / 8.0 < spread


@pytest.mark.parametrize("sampling", RANDOM)
def test_seeds(sampling: Any) -> None:
    """Equal seed and index give equal bits; another seed or another index gives other points."""
    ball = Source.of("sphere", variation=Variation(stiffness=0.5))
    first, again = (fill(ball, Numerics(sampling=sampling, seed=4), 1) for _ in range(2))
    for name in ("x", "v", "volume", "stiffness"):
        assert np.array_equal(getattr(first, name), getattr(again, name))
    for other in (
        fill(ball, Numerics(sampling=sampling, seed=5), 1),
        fill(ball, Numerics(sampling=sampling, seed=4), 2),
    ):
        n = min(len(first.x), len(other.x))
        assert not np.allclose(first.x[:n], other.x[:n])
        assert not np.allclose(first.stiffness[:n], other.stiffness[:n])


def test_velocity_and_spin() -> None:
    """v = velocity + spin x (x - center); the momentum is that of the centre, up to the sampling's offset."""
    ball = Source.of("sphere", center=(1.0, 2.0, 3.0), velocity=(4.0, 0.0, -1.0), spin=(0.0, 0.0, 2.0))
    samples = fill(ball, Numerics(), 0)
    x, y, _ = (samples.x - ball.center).T
    assert samples.v == pytest.approx(np.stack([4.0 - 2.0 * y, 2.0 * x, np.full(len(x), -1.0)], axis=1))
    layer = fill(
        Source.of("layer", center=(5.0, 0.0), base=1.0, depth=0.4, spin=(1.0, 0.0, 0.0)), Numerics(), 0
    )
    assert layer.v[:, 1] == pytest.approx(-(layer.x[:, 2] - 1.2))


def test_stiffness() -> None:
    """1 without noise; otherwise within exp(-a) and exp(a), median near 1, and fixed to the source."""
    assert np.array_equal(np.unique(fill(Source.of("box"), Numerics(), 0).stiffness), [1.0])
    noise = Variation(stiffness=0.8, feature_size=0.15)
    here = fill(Source.of("box", variation=noise), Numerics(dx=0.03), 0).stiffness
    assert np.exp(-0.8) <= here.min() < 0.6
    assert 1.6 < here.max() <= np.exp(0.8)
    assert np.median(here) == pytest.approx(1.0, abs=0.1)
    there = fill(
        Source.of("box", center=(50.0, 0.0, 0.0), rotation=(0, 0, 45), variation=noise), Numerics(dx=0.03), 0
    )
    assert np.array_equal(here, there.stiffness)


def test_letters_have_the_asked_size() -> None:
    """A capital H is `height` high and `depth` thick, stands upright, and reads along x."""
    samples = fill(
        Source.of("text", text="HI", height=0.8, depth=0.3, center=(0, 0, 2)), Numerics(dx=0.03), 0
    )
    low, high = samples.x.min(axis=0), samples.x.max(axis=0)
    assert (high - low)[1:] == pytest.approx([0.3, 0.8], abs=0.02)
    assert 0.5 * (low + high) == pytest.approx([0.0, 0.0, 2.0], abs=0.02)
    left, middle = samples.x[:, 0] < low[0] + 0.1, np.abs(samples.x[:, 2] - 2.0) < 0.05
    assert np.ptp(samples.x[left, 2]) > 0.75, "the left stem of the H is full height"
    gap = (samples.x[:, 0] > low[0] + 0.25) & (samples.x[:, 0] < low[0] + 0.35)
    assert gap[middle].any(), "the bar of the H is in the middle"
    assert not (gap & (samples.x[:, 2] > 2.3)).any(), "the H is open above its bar"


def test_lines_of_text_are_stacked() -> None:
    """A line break starts a line below; the block is centred."""
    one = fill(Source.of("text", text="HH", center=(0, 0, 0)), Numerics(), 0)
    two = fill(Source.of("text", text="HH\nHH", center=(0, 0, 0)), Numerics(), 0)
    assert two.volume.sum() == pytest.approx(2 * one.volume.sum(), rel=0.01)
    assert 2.0 < np.ptp(two.x[:, 2]) < 2.8
    assert np.abs(two.x[:, 2]).min() > 0.02, "the lines do not touch"
    assert two.x[:, 2].mean() == pytest.approx(0.0, abs=0.02)


def test_volume_of_letters_does_not_depend_on_dx() -> None:
    """The picture of the letters is fine enough at any dx: the same volume within 1 %."""
    word = Source.of("text", text="Snow & ice")
    coarse, fine = (fill(word, Numerics(dx=dx), 0).volume.sum() for dx in (0.12, 0.04))
    assert coarse == pytest.approx(fine, rel=0.01)


def test_letter_that_the_font_lacks() -> None:
    """The bundled font has no Chinese; the sentence says which letters and what to do."""
    with pytest.raises(
        SceneError,
        match=r"^sources\.2\.text: the bundled font has no glyph for 雪 \(U\+96EA .*\), 山 \(.*\); name",
    ):
        fill(Source.of("text", text="a 雪山"), Numerics(), 2)
    fill(Source.of("text", text="Àé ñ ß 123!?"), Numerics(), 0)


def test_font_that_is_no_font(tmp_path: Path) -> None:
    """A file that is no font."""
    path = tmp_path / "a.ttf"
    path.write_text("not a font")
    with pytest.raises(SceneError, match=r"sources\.0\.font = .* is not a font that can be read"):
        fill(Source.of("text", font=str(path)), Numerics(), 0)


def test_too_small_and_too_large() -> None:
    """A source without a single particle, and one that would fill the memory."""
    with pytest.raises(SceneError, match=r"sources\.1 would take .* numerics\.dx = 0\.0001, more than"):
        fill(Source.of("box"), Numerics(dx=1e-4), 1)
    tiny = Source.of("box", size=(1e-5, 1e-5, 1e-5))
    with pytest.raises(SceneError, match=r"sources\.0 is too small for a single particle"):
        fill(tiny, Numerics(sampling="poisson"), 0)
    assert len(fill(tiny, Numerics(), 0).x) == 1
