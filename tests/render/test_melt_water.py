"""Melt water in pictures: what lies on the ground and how deep, how wet snow is, what the preview shows."""

import numpy as np
import pytest

from neve.build import solids
from neve.colliders.motion import pose
from neve.geometry.pose import Pose, rotation_matrix
from neve.render.melt_water import DAMP, WATER, lying_on, melt_water, puddle_of
from neve.render.preview import Preview
from neve.scene.schema.scene import Camera, Collider, Light, Numerics, Scene, Source

SIZE = (320, 180)
S = 0.05  # spacing of particles [m]
RNG = np.random.default_rng(5)


def stage(camera=None):
    """A scene with nothing but the ground."""
    return Scene(
        sources=(Source.of("sphere"),),
        colliders=(Collider.of("plane"),),
        camera=camera or Camera(position=(0.0, -4.0, 1.2), target=(0.0, 0.0, 0.3), fov=30),
        light=Light(sun_azimuth=240, sun_elevation=30),
        numerics=Numerics(dx=2 * S),
    )


def placed(scene):
    """The solids of a scene where they are."""
    return [(s, pose(c, 0.0)) for s, c in zip(solids(scene), scene.colliders, strict=True)]


def block(low=(-0.4, -0.4, 0.1), count=(16, 16, 12)):
    """Packed snow, jittered."""
    x = np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), -1).reshape(-1, 3) * S
    return (x + low + RNG.uniform(-0.3, 0.3, x.shape) * S).astype(np.float32)


def drawn(x, water=None, J_P=None, camera=None):
    """The preview of particles."""
    scene = stage(camera)
    return Preview(scene, *SIZE, threads=1).draw(x, placed(scene), J_P, water=water).astype(float)


def test_a_puddle_holds_its_water():
    """The integral of the depth over the plane is the volume of the particles, on a slope as on level ground:
    blurs keep sums."""
    x = RNG.normal(size=(400, 3)) * [0.3, 0.2, 0.0]
    volume = RNG.uniform(1e-5, 5e-5, 400)
    slope = Pose.at_rest(np.array([0.1, -0.2, 0.3]), rotation_matrix(np.array([0.3, 0.2, 0.5])))
    found = puddle_of(slope, x @ slope.rotation.T + slope.position, volume, S)
    assert found.depth.sum(dtype=float) * found.cell**2 == pytest.approx(volume.sum(), rel=1e-5)
    u, v = found.origin + 0.5 * found.cell + found.cell * np.array([4.0, 7.0])
    assert found.at(u, v) == pytest.approx(found.depth[4, 7], rel=1e-5)
    assert found.wetness(u, v) == pytest.approx(1 - np.exp(-found.depth[4, 7] / DAMP), abs=1e-6)
    assert found.at(99.0, 0.0) == 0.0


def test_water_lies_on_the_ground_drops_fly_and_snow_soaks_it_up():
    """Water by the ground lies, far from all snow it flies, within snow it soaks; slush does none of it."""
    snow = block()
    more = np.array([[1.0, 0.0, 0.01], [1.0, 0.0, 0.5], [0.0, 0.0, 0.4], [0.5, 0.0, 0.01]], np.float32)
    x = np.concatenate([snow, more])
    water = np.concatenate([np.zeros(len(snow)), [1.0, 1.0, 1.0, 0.5]]).astype(np.float32)
    bodies = placed(stage())
    assert {k: rows.tolist() for k, rows in lying_on(bodies, x, water, S).items()} == {0: [len(snow)]}
    found = melt_water(bodies, x, water, np.where(water > WATER, 0.4, 0.9), S)
    assert found.rows.tolist() == [*range(len(snow)), *(len(snow) + np.arange(1, 4))]
    assert np.flatnonzero(found.flies).tolist() == [len(snow)]
    assert np.flatnonzero(found.soaks).tolist() == [len(snow) + 1]
    assert found.volume[-3:] == pytest.approx([0.4, 0.4, 0.95])
    assert found.puddles[0].depth.sum(dtype=float) * S**2 == pytest.approx(0.4 * S**3, rel=1e-5)
    assert melt_water(bodies, x, 0 * water, None, S) is None


def test_dry_snow_is_drawn_as_without_heat():
    """No particle is wet: the same bytes as of a scene that knows no heat."""
    x = block()
    assert np.array_equal(drawn(x, np.zeros(len(x), np.float32)), drawn(x))


def test_slush_is_darker_than_snow_and_smoother():
    """Half melted, the block's sunlit side is darker, bluer, and its neighbouring pixels differ by less."""
    x = block()
    dry, wet = drawn(x), drawn(x, np.full(len(x), 0.5, np.float32))
    side = slice(62, 98), slice(130, 190)
    assert (np.abs(dry[side] - drawn(x[:0])[side]).mean(axis=2) > 5).all()  # snow it is
    assert wet[side].mean() < dry[side].mean() - 8
    assert (
        wet[side][..., 2].mean() / wet[side][..., 0].mean()
        > dry[side][..., 2].mean() / dry[side][..., 0].mean()
    )

    def rough(image):
        return np.abs(np.diff(image[side].mean(axis=2), axis=1)).mean() / image[side].mean()

    assert rough(wet) < 0.6 * rough(dry)


def test_water_on_the_ground_is_a_dark_patch():
    """Seen from above, ground with a layer of water is darker than dry ground, and no ball stands on it."""
    above = Camera(position=(0.0, -0.6, 3.0), target=(0.0, 0.0, 0.0), fov=30)
    x = np.concatenate([np.stack(np.meshgrid(*[np.arange(-8, 8)] * 2, indexing="ij"), -1).reshape(-1, 2) * S])
    x = np.concatenate([x, np.full((len(x), 1), 0.4 * S)], axis=1).astype(np.float32)
    dry = drawn(x[:0], camera=above)
    wet = drawn(x, np.ones(len(x), np.float32), np.full(len(x), 0.4, np.float32), above)
    middle, corner = (slice(70, 110), slice(140, 180)), (slice(0, 12), slice(0, 20))
    assert wet[middle].mean() < 0.8 * dry[middle].mean()
    assert np.array_equal(wet[corner], dry[corner])


def test_water_without_numbers_is_left_out():
    """A particle that is not finite changes nothing, be it snow or water."""
    x, lost = block(), np.float32([[np.nan, 0, 0], [0, np.inf, 0], [0, 0, -np.inf]])
    share = np.where(np.arange(len(x)) % 3, 0.2, 1.0).astype(np.float32)
    both = np.concatenate([x, lost]), np.concatenate([share, np.ones(3, np.float32)])
    assert np.array_equal(drawn(*both), drawn(x, share))


def test_a_drop_is_clear():
    """A drop before snow changes its light by little: what it shows is the snow, not what lies behind it."""
    x = block()
    drop = np.array([[-0.2, -0.75, 0.4]], np.float32)
    both, share = np.concatenate([x, drop]), np.zeros(len(x) + 1, np.float32)
    share[-1] = 1.0
    dry, wet = drawn(x), drawn(both, share)
    changed = np.argwhere(np.abs(wet - dry).max(axis=2) > 1)
    assert 2 < len(changed) < 300  # its faint shadow, too
    rows = changed.min(axis=0), changed.max(axis=0) + 1
    inside = tuple(slice(a, b) for a, b in zip(*rows, strict=True))
    assert wet[inside].mean() == pytest.approx(dry[inside].mean(), rel=0.25)


def test_close_snow_has_finer_grains():
    """Packed snow whose particles are ten pixels large is a surface with grain, not beads: within and between
    squares of four pixels light varies by 3.7 and 3.1 of 255; as 16 balls for each particle it did by 5.8 and
    5.7."""
    x = block((-0.8, -0.4, 0.0), (32, 16, 8))
    near = Camera(position=(0.0, -1.9, 1.0), target=(0.0, 0.0, 0.35), fov=30)
    light = drawn(x, camera=near)[70:150, 60:260].mean(axis=2)
    blocks = light.reshape(20, 4, 50, 4)
    within, means = blocks.std(axis=(1, 3)).mean(), blocks.mean(axis=(1, 3))
    assert 1.0 < within < 4.6
    assert np.diff(means, axis=1).std() < 4.4
