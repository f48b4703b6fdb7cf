"""Shapes: one class each, which is a source, a collider or a body by its role, and agrees with the core."""

import numpy as np
import pytest

from neve import _core
from neve.mpm.initial import make_model
from neve.scene.schema.roles import SHAPES, Role, forms
from neve.scene.schema.scene import Body, Collider, Numerics, Scene, Source

PLACE = {"center": (0.3, -0.2, 0.8), "rotation": (20.0, -30.0, 40.0)}
SIZES = {
    "box": {"size": (0.6, 0.4, 0.2)} | PLACE,
    "sphere": {"radius": 0.3, "center": PLACE["center"]},
    "cylinder": {"radius": 0.2, "height": 0.7} | PLACE,
}


def sampled(word):
    """Return a collider, its half extents, points around it in its own axes (n, 3), and phi there (n,)."""
    collider = Collider.of(word, **SIZES[word])
    model = make_model(Scene(sources=(Source.of("box"),), colliders=(collider,), numerics=Numerics(dx=0.1)))
    half = np.array(collider.half_extents())
    local = np.random.default_rng(7).uniform(-1.2, 1.2, (4000, 3)) * half
    pose = model.poses(0.0)[0]
    phi, _ = model.native.surface(0, np.ascontiguousarray(pose.position + local @ pose.rotation.T))
    return collider, half, local, phi


def test_the_core_knows_the_same_words() -> None:
    """The core's list has the shapes of colliders, in the same order."""
    assert _core.geometry.shapes() == tuple(forms(Collider))


@pytest.mark.parametrize("word", SIZES)
def test_snow_fills_what_the_solid_of_the_same_shape_takes(word) -> None:
    """A point of the box around a shape is in its snow where the signed distance of its solid is negative.

    The core's own numbers are single: points within 1e-6 of the surface are left out.
    """
    shape, half, local, phi = sampled(word)
    inside = shape.covers(half, local) & (np.abs(local) <= half).all(axis=1)
    clear = np.abs(phi) > 1e-6
    assert clear.sum() > 3900
    assert np.array_equal(inside[clear], phi[clear] < 0)


@pytest.mark.parametrize("word", SIZES)
def test_depth_is_the_distance_to_the_surface(word) -> None:
    """Inside, the depth of snow is -phi of the solid, to single precision."""
    shape, half, local, phi = sampled(word)
    inside = phi < 0
    np.testing.assert_allclose(shape.depth_of(half, local)[inside], -phi[inside], atol=1e-6)


@pytest.mark.parametrize("word", SIZES)
def test_volume_moments_and_extents_are_those_of_the_inside(word) -> None:
    """Sums over a lattice of 60^3 points of the box: errors of a share of 1 / 60 at the surface at most."""
    shape = SHAPES[word]
    half = np.array(Collider.of(word, **SIZES[word]).half_extents())
    line = (np.arange(60) + 0.5) / 30 - 1
    x = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3) * half
    x = x[shape.covers(half, x)]
    assert shape.volume_of(half) == pytest.approx(8 * half.prod() * len(x) / 60**3, rel=1 / 60)
    assert shape.mean_squares(half) == pytest.approx((x**2).mean(axis=0), rel=1 / 60)
    assert np.linalg.norm(x, axis=1).max() == pytest.approx(shape.reach_of(half), rel=3 / 60)
    assert np.linalg.norm(x, axis=1).max() <= shape.reach_of(half)


@pytest.mark.parametrize("word", SIZES)
def test_the_size_goes_to_the_engine_and_back(word) -> None:
    """Half extents -> size of the engine's geom -> half extents, the same numbers."""
    shape = SHAPES[word]
    half = np.array(Collider.of(word, **SIZES[word]).half_extents())
    assert shape.half_of_geom(shape.geom_size(half)) == half.tolist()


@pytest.mark.parametrize("role", [Source, Collider, Body])
def test_a_role_has_the_keys_of_its_shape_and_its_own(role: type[Role]) -> None:
    """Each model of a role has the keys of both; a shape that the role cannot have is refused by its word."""
    for word, model in forms(role).items():
        assert {*SHAPES[word].model_fields, *role.model_fields} == {*model.model_fields}
        assert issubclass(model, role)
        assert issubclass(model, SHAPES[word])
    with pytest.raises(ValueError, match=f'a {role.role} has no shape "cube": use one of .*sphere'):
        role.of("cube")
