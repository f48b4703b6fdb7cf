"""The density that light meets: it holds what the particles hold, and costs memory only where they are."""

import numpy as np
import pytest

from neve._render import Density

H = 0.1  # [m]


def cube(low, high, spacing):
    """Particles on a lattice in the box low..high, (n, 3) float32."""
    axes = [np.arange(a + spacing / 2, b, spacing) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3).astype(np.float32)


@pytest.mark.parametrize("level", range(6))
def test_grid_holds_the_particles_volume(level):
    """Sum over cells of fraction * h^3 = n * volume on every level: B-spline weights sum to one, and
    averaging eight cells keeps their sum. Tolerance: rounding of n float32 sums."""
    x = np.random.default_rng(3).uniform(-2, 2, (5000, 3)).astype(np.float32)
    total = Density(x, 2e-4, H).total(level)
    assert total == pytest.approx(5000 * 2e-4, rel=1e-5)


def test_solid_snow_has_fraction_one():
    """A lattice of n particles per metre cubed with the volume 1/n fills space: the fraction inside is 1."""
    density = Density(cube((-1, -1, -1), (1, 1, 1), H / 2), (H / 2) ** 3, H)
    inside = np.random.default_rng(4).uniform(-0.7, 0.7, (200, 3)).astype(np.float32)
    assert density.sample(inside) == pytest.approx(1.0, abs=1e-4)


def test_a_particle_spreads_over_three_cells():
    """At its cell's centre the quadratic B-spline gives a particle the weight (3/4)^3; a cell and a half
    away, interpolated between 1/8 and 0, it gives (1/8)/2 * (3/4)^2; beyond two cells nothing."""
    x = np.array([[0.05, 0.05, 0.05]], np.float32)
    at = np.array([[0.05, 0.05, 0.05], [0.20, 0.05, 0.05], [0.26, 0.05, 0.05]], np.float32)
    expected = [0.75**3, 0.125 / 2 * 0.75**2, 0.0]
    assert Density(x, H**3, H).sample(at) == pytest.approx(expected, abs=1e-6)


def test_a_far_flake_costs_a_block():
    """A flake ten kilometres away costs one block of every level (it lies in the middle of one of the
    finest)."""
    near = cube((0, 0, 0), (1, 1, 1), H / 2)
    far = np.array([[10_000.2, 10_000.2, 10_000.2]], np.float32)
    both, alone = (Density(x, 1e-4, H) for x in (np.concatenate([near, far]), near))
    assert both.blocks(0) - alone.blocks(0) == 1
    assert sum(both.blocks(level) - alone.blocks(level) for level in range(6)) <= 6 * 8


def test_particles_that_are_not_finite_are_left_out():
    """NaN, infinity and places beyond any grid add nothing and do no harm."""
    good = np.full((1, 3), 0.05, np.float32)
    bad = np.array([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, -np.inf], [3e38, 0, 0]], np.float32)
    density = Density(np.concatenate([bad, good, bad]), H**3, H)
    assert density.total(0) == pytest.approx(H**3, rel=1e-6)
    assert density.blocks(0) == Density(good, H**3, H).blocks(0)


def test_no_particles():
    """Without snow every sample is zero and all light arrives."""
    density = Density(np.zeros((0, 3), np.float32), 1e-4, H)
    at = np.zeros((1, 3), np.float32)
    assert density.sample(at) == [0]
    assert density.sun(at, (0, 0, 1)) == [1]
    assert density.sky(at, (0, 0, 1)) == pytest.approx(1.0, abs=1e-2)


SUN = (-np.cos(np.radians(30)), 0.0, np.sin(np.radians(30)))


def test_shadow_of_a_ball_falls_where_the_sun_says():
    """With the sun at 30 degrees in the west (-x), a ball at height z throws its shadow z / tan 30 to the
    east."""
    x = cube((-0.5, -0.5, 0.5), (0.5, 0.5, 1.5), H / 2)
    x = x[np.linalg.norm(x - [0, 0, 1.0], axis=1) < 0.5]
    density = Density(x, (H / 2) ** 3, H)
    middle = 1.0 / np.tan(np.radians(30))
    ground = np.array([[middle, 0, 0], [middle, 1.2, 0], [-middle, 0, 0], [0, 0, 0]], np.float32)
    sun = density.sun(ground, SUN)
    assert sun[0] < 0.01
    assert sun[1:].tolist() == [1, 1, 1]


def test_light_falls_exponentially_through_snow():
    """A slab of solid snow of d cells leaves exp(-1.2 d) of a sun above it (Beer and Lambert; the
    constant is the renderer's own). Steps are one cell long: the tolerance is half a step."""
    for cells in (1, 2, 3):
        slab = cube((-1, -1, 0), (1, 1, cells * H), H / 4)
        sun = Density(slab, (H / 4) ** 3, H).sun(np.array([[0, 0, -0.3]], np.float32), (0, 0, 1))
        assert np.log(sun[0]) == pytest.approx(-1.2 * cells, abs=0.6)


def test_a_roof_hides_the_sky():
    """Under a wide roof hardly any sky is left, beside it some, far from it all."""
    density = Density(cube((-2, -2, 1.0), (2, 2, 1.4), H / 2), (H / 2) ** 3, H)
    under, edge, away = density.sky(
        np.array([[0, 0, 0.2], [2.2, 0, 0.2], [30, 0, 0.2]], np.float32), (0, 0, 1)
    )
    assert under < 0.25 < edge < 0.9 < away


@pytest.mark.parametrize(
    "eye", [(40, -60, 30), (0, 0, 5), (0.1, 0.2, 0.3), (1.2, 0, 0), (0, -1.05, 0.3), (-3, -3, -3)]
)
@pytest.mark.parametrize("holes", [0, 3, 40])
def test_what_a_block_calls_buried_is_buried(eye, holes):
    """A block speaks for all its points, whatever holes there are: it may miss some that looking towards the
    eye finds, and never takes one that is to be seen. In a heap without holes it finds most."""
    rng = np.random.default_rng(holes)
    x = cube((-1, -1, -1), (1, 1, 1), H / 4)
    x = (x + rng.uniform(-H / 8, H / 8, x.shape)).astype(np.float32)
    for middle in rng.uniform(-1, 1, (holes, 3)):
        x = x[((x - middle) ** 2).sum(1) > (1.5 * H) ** 2]
    density = Density(x, (H / 4) ** 3, H / 2)
    deep, buried = density.deep(x, eye) > 0, density.buried(x, eye) > 0
    assert not (deep & ~buried).any()
    assert deep.sum() > (0.6 * buried.sum() if holes == 0 else 0)
