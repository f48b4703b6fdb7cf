"""Fragments of snow whose pieces are known: balls apart, touching, cut, permuted, torn; a lattice."""

import numpy as np
import pytest

from neve import fragments
from neve.sampling import fill
from neve.scene.schema.scene import Numerics, Source

DX = 0.05
SPACING = DX / 2  # eight particles a cell
RADIUS = 0.2


def ball(centre=(0.0, 0.0, 0.0), radius=RADIUS, seed=0):
    """Particles of a snowball as a run places them, (n, 3)."""
    return fill(Source.of("sphere", center=centre, radius=radius), Numerics(dx=DX, seed=seed), 0).x


def find(x, J_P=None, v=None, m=None, **limits):
    """Fragments of points with unit mass and volume, at rest and whole unless told."""
    n = len(x)
    return fragments.find(
        x,
        np.zeros((n, 3)) if v is None else v,
        np.ones(n) if J_P is None else J_P,
        np.ones(n) if m is None else m,
        np.ones(n),
        SPACING,
        **limits,
    )


@pytest.mark.parametrize("sampling", ["jittered", "poisson"])
def test_snow_as_it_is_placed_is_one_piece(sampling):
    """No particle of a fresh ball is alone: the link is longer than the gaps that either sampling leaves."""
    x = fill(Source.of("sphere", radius=RADIUS), Numerics(dx=DX, sampling=sampling), 0).x
    f = find(x)
    assert (f.count, f.particles.tolist()) == (1, [0, len(x)])


def test_two_balls_apart_and_touching():
    """Balls whose surfaces lie two links apart are two fragments, the larger first; overlapping a link, one.

    Particles lie within the balls, so those of the two are at least the gap of the surfaces apart.
    """
    gap = 2 * fragments.LINK * SPACING
    small = 0.7 * RADIUS
    apart = np.concatenate([ball((-small - gap, 0, 0), small), ball((RADIUS, 0, 0))])
    near = np.concatenate([ball((-small + gap, 0, 0), small), ball((RADIUS, 0, 0))])
    f = find(apart)
    assert f.count == 2
    assert f.mass[1:].tolist() == f.particles[1:].tolist() == [len(ball()), len(apart) - len(ball())]
    assert np.array_equal(f.label == 1, apart[:, 0] > 0)
    assert find(near).count == 1


@pytest.mark.parametrize(("width", "count"), [(1.0, 2), (0.0, 1)])
def test_ball_cut_by_a_gap(width, count):
    """A ball whose halves are moved apart by one link more than touching is two; not moved, one."""
    x = ball()
    x[:, 2] += np.where(x[:, 2] > 0, width * fragments.LINK * SPACING, 0.0)
    assert find(x).count == count


def test_order_of_particles_does_not_matter():
    """Permuted particles: the same sets of particles, and sums within rounding of n terms."""
    rng = np.random.default_rng(3)
    x = np.concatenate([ball((0.6 * k, 0, 0), r) for k, r in enumerate((0.2, 0.15, 0.1))])
    v, m, J_P = rng.normal(size=x.shape), rng.uniform(1, 2, len(x)), rng.uniform(0.9, 1.3, len(x))
    order = rng.permutation(len(x))
    a, b = find(x, J_P, v, m), find(x[order], J_P[order], v[order], m[order])
    assert np.array_equal(a.label[order], b.label)
    for name in ("particles", "mass", "volume", "size", "centre", "velocity"):
        np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-12, atol=1e-12)


def test_sums_of_a_uniform_ball():
    """Mass and momentum are those of all particles; the size of a ball is its diameter.

    R_g^2 of particles placed one a cell of a lattice differs from 3/5 R^2 by the error of a sum over cells
    that the surface cuts: about (spacing / R)^2 of the whole, 2 % at R = 8 spacings.
    """
    rng = np.random.default_rng(0)
    x = np.concatenate([ball(), ball((1, 0, 0), 0.12)])
    v, m = rng.normal(size=x.shape), rng.uniform(1, 2, len(x))
    J_P = np.where(np.arange(len(x)) % 50, 1.0, 2.0)  # some of it torn
    f = find(x, J_P, v, m)
    assert f.count == 2
    assert f.mass[0] > 0
    assert f.mass.sum() == pytest.approx(m.sum(), rel=1e-12)
    assert f.volume.sum() == pytest.approx(J_P.sum(), rel=1e-12)
    np.testing.assert_allclose(f.mass @ f.velocity, m @ v, rtol=1e-11)
    np.testing.assert_allclose(f.mass @ f.centre, m @ x, rtol=1e-11)
    alone = find(ball((0.3, 0.2, 0.1)))
    assert alone.size[1] == pytest.approx(2 * RADIUS, rel=0.02)
    np.testing.assert_allclose(alone.centre[1], (0.3, 0.2, 0.1), atol=0.02 * RADIUS)


@pytest.mark.parametrize(("link", "count"), [(1 + 1e-9, 1), (1 - 1e-9, 0)])
def test_lattice_at_the_limit(link, count):
    """A lattice hangs together by links as long as its spacing, and falls to single grains just below."""
    x = SPACING * np.stack(np.meshgrid(*[np.arange(6)] * 3), axis=-1).reshape(-1, 3)
    f = find(x, limits=fragments.Limits(link=link))
    assert (f.count, int(f.particles[0])) == (count, 0 if count else 216)


def test_torn_snow_and_crumbs_are_powder():
    """A torn slice parts a ball; a torn ball, a crumb below the limit and a lost particle are powder."""
    x = ball()
    slab = np.abs(x[:, 2]) < fragments.LINK * SPACING / 2
    assert find(x, np.where(slab, fragments.TORN * 1.001, 1.0)).count == 2
    assert find(x, np.where(slab, fragments.TORN * 0.999, 1.0)).count == 1
    assert find(x, np.full(len(x), 2.0)).particles.tolist() == [len(x)]
    crumb = np.repeat([[9.0, 0, 0]], fragments.LEAST, axis=0)
    assert find(np.concatenate([x, crumb])).particles[1:].tolist() == [len(x), fragments.LEAST]
    few = find(np.concatenate([x, crumb[1:], [[np.nan, 0, 0]]]))
    assert few.particles.tolist() == [fragments.LEAST, len(x)]
    assert not few.label[-1]


def test_no_particles_and_no_powder():
    """Nothing has no fragments; powder that is not there has no centre."""
    assert find(np.zeros((0, 3))).particles.tolist() == [0]
    f = find(ball())
    assert f.mass[0] == 0
    assert np.isnan(f.centre[0]).all()
    assert np.isfinite(f.centre[1]).all()


def test_size_classes_are_half_decades_of_the_whole_mass():
    """Balls of 1000, 50, 40 and 8 particles of equal mass and some dust: 85.6 %, 4.3 and 3.4 %, 0.7 %."""
    rng = np.random.default_rng(0)
    x = [np.array([10.0 * k, 0, 0]) + 1e-3 * rng.random((n, 3)) for k, n in enumerate((1000, 50, 40, 8))]
    dust = np.array([[0.0, 10.0 + k, 0.0] for k in range(70)])
    classes = fragments.size_classes(find(np.concatenate([*x, dust])))
    expected = np.zeros(10)
    expected[[0, 2, 4]] = np.array([1000, 50 + 40, 8]) / 1168
    np.testing.assert_allclose(classes, expected, rtol=1e-12)
