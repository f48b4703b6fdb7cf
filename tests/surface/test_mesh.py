"""Surfaces: closed, turned outwards, where the field says, with the velocity of the snow below."""

import numpy as np
import pytest

from neve._surface import Field
from neve.surface.grains import grains_of
from neve.surface.mesh import mesh_of, snow_field, snow_surface

RNG = np.random.default_rng(5)


def lattice(shape, spacing):
    """Points of a cubic lattice that starts at half a spacing."""
    return (np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1).reshape(-1, 3) + 0.5) * spacing


def free_edges(mesh):
    """Directed edges of triangles that no triangle on the other side has, the other way round."""
    n = len(mesh.vertices)
    pairs = np.concatenate([mesh.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]).astype(np.int64)
    there, back = np.sort(pairs[:, 0] * n + pairs[:, 1]), np.sort(pairs[:, 1] * n + pairs[:, 0])
    return np.count_nonzero(there != back)


def test_any_surface_is_closed_and_turned_outwards():
    """Each edge is walked as often one way as the other; the volume inside is positive; normals lead to
    lower values."""
    x = RNG.normal(size=(400, 3)).astype(np.float32)
    field = Field(x, np.ones(1, np.float32), 0.25, 1)
    mesh = mesh_of(field, 0.04)
    assert len(mesh.faces) > 1000
    assert free_edges(mesh) == 0
    assert mesh.volume > 0
    step = 0.05 * mesh.normals
    assert np.mean(field.sample(mesh.vertices + step) < field.sample(mesh.vertices - step)) > 0.98


def test_a_box_of_snow_has_its_volume_and_its_sides():
    """Particles that fill a box: the surface lies on its sides, in their middle to a tenth of a cell."""
    h = 0.05
    x = lattice((20, 20, 20), h)
    mesh = snow_surface(x, h)
    sides = mesh.vertices[(np.abs(mesh.vertices[:, 1:] - 0.5) < 0.3).all(axis=1), 0]
    assert np.minimum(np.abs(sides), np.abs(sides - 1.0)).max() < 0.1 * h
    assert mesh.volume == pytest.approx(1.0, rel=0.03)
    assert free_edges(mesh) == 0


def test_vertices_move_with_the_snow():
    """In a rigid rotation each vertex has the velocity w x r, to half a spacing times w."""
    h, w = 0.05, np.array([0.3, -0.5, 2.0])
    x = lattice((12, 12, 12), h)
    mesh = snow_surface(x, h, v=np.cross(w, x))
    off = np.linalg.norm(mesh.velocity - np.cross(w, mesh.vertices), axis=1)
    assert off.max() < 0.75 * h * np.linalg.norm(w)


def test_no_snow_has_no_surface():
    """No particles, or one that is alone, have no surface."""
    for x in (np.zeros((0, 3)), np.zeros((1, 3))):
        mesh = snow_surface(x, 0.1, v=np.zeros_like(x))
        assert mesh.faces.shape == (0, 3)
        assert mesh.velocity.shape == (0, 3)


def test_grains_of_a_particle_depend_on_it_alone():
    """Reordered and moved particles (by whole cells) have the same grains, reordered and moved."""
    x = lattice((6, 6, 6), 0.1).astype(np.float32)
    id = np.arange(len(x)) * 7 + 3
    here = grains_of(x, id, 0.1, 8).x.reshape(-1, 8, 3) - x[:, None]
    order = RNG.permutation(len(x))
    there = grains_of(x[order] + np.float32(0.6), id[order], 0.1, 8).x.reshape(-1, 8, 3)
    assert np.abs(there - (x[order] + np.float32(0.6))[:, None] - here[order]).max() < 1e-5
    assert len(np.unique(here.round(6), axis=0)) == len(x)


def test_grains_fill_the_cell_of_a_particle():
    """Within snow the grains of a particle lie in its cell of side 1.15 spacing; all of a lattice make snow
    of the share 1, without holes."""
    x = lattice((12, 12, 12), 0.1)
    grains = grains_of(x, np.arange(len(x)), 0.1, 27)
    deep = np.flatnonzero((np.abs(x - 0.6) < 0.3).all(axis=1))
    assert grains.lone[deep].max() == 0.0
    offset = grains.x.reshape(-1, 27, 3)[deep] - x[deep, None]
    assert np.abs(offset).max() <= 0.0575 + 1e-6
    inside = RNG.uniform(0.3, 0.9, (4000, 3)).astype(np.float32)
    share = snow_field(grains).sample(inside)
    assert share.mean() == pytest.approx(1.0, abs=0.01)
    assert share.min() > 0.5


def test_a_lone_particle_comes_apart_into_crumbs():
    """A particle without neighbours is alone; its grains lie in clusters of halving size, not in a cube."""
    grains = grains_of(np.zeros((1, 3)), np.array([11]), 0.1, 64)
    assert grains.lone == pytest.approx([1.0], abs=0.05)
    first = grains.x[:32]  # the crumb with half of the mass
    assert np.linalg.norm(first - first.mean(axis=0), axis=1).max() < 1.3 * 0.62 * 32 ** (1 / 3) * grains.size
    assert np.linalg.norm(grains.x, axis=1).max() < 2.1 * 0.1
