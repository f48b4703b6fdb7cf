"""Emitters: what comes out follows from the way of the flow, and from nothing else."""

import math
from itertools import pairwise

import numpy as np
import pytest

from neve.sampling.emitters.stream import directed, stream
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from

BOX = {"shape": "box", "size": [0.1, 0.4, 0.2], "center": [1, 2, 3], "velocity": [2, 0, 0]}
SPACING = 0.025  # of eight particles in a cell of 0.05 m


def of(emitter, **numerics):
    return stream(scene_from({"emitters": [emitter], "numerics": {"dx": 0.05, **numerics}}), 0)


@pytest.mark.parametrize("more", [{}, {"mass_rate": 1.5}, {"volume_rate": 0.013}])
def test_any_cuts_give_the_same_snow(more):
    """Cut into few or many parts, the column is the same: nothing is left out, nothing comes twice."""
    source = of({**BOX, **more})
    whole = source.comers(0.0, 7.3)
    for cuts in (np.linspace(0, 7.3, 3), np.sort(np.r_[0, np.random.default_rng(1).random(60) * 7.3, 7.3])):
        parts = [source.comers(a, b) for a, b in pairwise(cuts)]
        for k, values in enumerate(whole):
            np.testing.assert_array_equal(np.concatenate([part[k] for part in parts]), values)


@pytest.mark.parametrize("sampling", ["jittered", "poisson", "regular"])
def test_the_column_is_as_dense_as_a_source(sampling):
    """One particle in a spacing cubed; none nearer than 0.3 spacings, across layers too; one mass."""
    source = of(BOX, sampling=sampling)
    assert len(source.middles) == 16 * 8
    assert source.volume / len(source.middles) == pytest.approx(SPACING**3, rel=1e-9)
    come = source.comers(0.0, 20.0)
    assert len(come.phase) == 20 * 16 * 8
    column = come.place - np.outer(come.phase * SPACING, [1.0, 0.0, 0.0])
    from scipy.spatial import cKDTree

    nearest = cKDTree(column).query(column, k=2)[0][:, 1].min()
    assert nearest >= (0.99 if sampling == "regular" else 0.3) * SPACING * (1 - 1e-9)
    assert np.abs(come.place - [1, 2, 3]).max(axis=0) == pytest.approx([0, 0.2, 0.1], abs=SPACING)
    assert (np.abs(come.place - [1, 2, 3]) <= [1e-12, 0.2, 0.1]).all()


@pytest.mark.parametrize(
    ("shape", "area"),
    [
        ({"shape": "sphere", "radius": 0.3}, math.pi * 0.09),
        ({"shape": "cylinder", "radius": 0.3, "height": 1, "rotation": [0, 90, 0]}, math.pi * 0.09),
        ({"shape": "cylinder", "radius": 0.3, "height": 1}, 0.6),
        ({"shape": "box", "size": [9, 0.5, 0.3], "rotation": [30, 0, 0]}, 0.15),
        ({"shape": "box", "size": [0.2, 0.5, 0.3], "rotation": [0, 0, 45]}, 0.2 * math.sqrt(2) * 0.3),
        ({"shape": "mesh", "file": "neve:rock"}, None),
        ({"shape": "text", "text": "I", "rotation": [0, 0, -90], "height": 0.5}, None),
    ],
)
def test_sections_of_shapes(shape, area):
    """The area is that of the shape across the velocity: a raster of a million points: 2e-3 of a round one.

    Particles lie in the section; their number is its area over the square of their distance, within a ring.
    """
    source = of({"velocity": [3, 0, 0], **shape})
    if area is not None:
        assert source.area == pytest.approx(area, rel=2e-3)
    place = source.comers(0.0, 1.0).place
    assert source.section.holds(place).all()
    assert np.ptp(place[:, 0]) < 1e-12
    assert len(place) == pytest.approx(source.area / SPACING**2, rel=0.25)


def test_mass_of_a_layer_gives_the_rate():
    """Layers per second times the mass of a layer is the rate that was asked for, or what fills it."""
    full = 0.08 * 2.0
    assert of(BOX).rate * of(BOX).volume == pytest.approx(full)
    assert of({**BOX, "mass_rate": 3.0}).rate * of({**BOX, "mass_rate": 3.0}).mass == pytest.approx(3.0)
    thin = of({**BOX, "volume_rate": 0.01})
    assert thin.rate * thin.volume == pytest.approx(0.01)
    assert thin.thinness == pytest.approx(full / 0.01)
    assert thin.expected(1.0, 3.0) == pytest.approx(0.02 / SPACING**3)
    assert of({**BOX, "start": 2.0, "end": 2.5}).expected(1.0, 3.0) == pytest.approx(0.5 * full / SPACING**3)


def test_thin_flow_comes_evenly():
    """Particles of a thin flow come one after another: in each tenth of a layer a tenth of it."""
    come = of({**BOX, "volume_rate": 1e-3}).comers(0.0, 50.0)
    share = np.histogram(come.phase % 1.0, 10, (0, 1))[0] / len(come.phase)
    assert np.abs(share - 0.1).max() < 0.02


def test_directions_fill_the_cone_evenly():
    """Within the cone cos(angle) is uniform, all ways around it are alike, and the speed is kept."""
    source = of({**BOX, "velocity": [1, 2, 2], "spread": 40, "volume_rate": 1e-2})
    aim = source.comers(0.0, 120.0).aim
    v = directed(np.array([1.0, 2.0, 2.0]), 40.0, aim)
    np.testing.assert_allclose(np.linalg.norm(v, axis=1), 3.0, rtol=1e-12)
    cosine = v @ np.array([1.0, 2.0, 2.0]) / 9.0
    least = math.cos(math.radians(40))
    assert cosine.min() >= least - 1e-12
    assert len(cosine) > 5000
    share = np.histogram((cosine - least) / (1 - least), 5, (0, 1))[0] / len(cosine)
    assert np.abs(share - 0.2).max() < 0.03
    np.testing.assert_allclose(v.mean(axis=0), 0.5 * (1 + least) * np.array([1, 2, 2]), atol=0.06)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            {"velocity": [0, 0, 0]},
            "emitters.0.velocity = [0, 0, 0] is not allowed: it must be at least",
        ),
        (
            {"mass_rate": 1.0, "volume_rate": 1.0},
            "emitters.0.volume_rate = 1.0 is not allowed",
        ),
        ({"mass_rate": 1000.0}, "emitters.0.mass_rate = 1000 must be at most 64"),
        ({"volume_rate": 0.2}, "emitters.0.volume_rate = 0.2 must be at most 0.16"),
        ({"mass_rate": -1.0}, "emitters.0.mass_rate"),
        (
            {"start": 2.0, "end": 1.0},
            "emitters.0.end = 1.0 is not allowed: it must be later than start, greater than 2",
        ),
        ({"spread": 120.0}, "emitters.0.spread"),
        ({"size": [1.0, 1e-6, 1e-6]}, None),
        ({"snow": {"nu": 0.9}}, "emitters.0.snow.nu"),
        ({"shape": "plane"}, "emitters.0.shape"),
        ({"speed": 3}, "emitters.0.speed"),
    ],
)
def test_what_cannot_be_is_one_sentence(change, told):
    """Impossible emitters name the key and what is allowed."""
    if told is None:
        assert len(of({**BOX, **change}).middles) == 1  # one particle, however thin the section is
        return
    with pytest.raises(SceneError) as error:
        of({**BOX, **change})
    assert told in str(error.value)
    assert "\n" not in str(error.value)
