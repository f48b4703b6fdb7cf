"""Layers that lie on the ground, and those with an outline."""

import numpy as np
import pytest

from neve import Simulation
from neve.mpm.initial import build
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.reading.load import load
from neve.scene.values.outline import area_of, crossing, holds

SLOPE = '[[colliders]]\nshape = "plane"\nnormal = [-0.5, 0, 1]\npoint = [0, 0, 0.3]\n'
L = [[-1, -1], [1, -1], [1, 0], [0, 0], [0, 1], [-1, 1]]


@pytest.fixture
def load_text(tmp_path):
    """Read a scene: a layer that lies on the ground, and colliders."""

    def read(layer, colliders, dx=0.1):
        path = tmp_path / "scene.toml"
        head = f'[numerics]\ndx = {dx}\n[[sources]]\nshape = "layer"\non = "terrain"\n'
        path.write_text(f"{head}{layer}\n{colliders}", encoding="utf-8")
        return load(path)

    return read


def map_of(tmp_path, f, n=81, side=4.0):
    """A height map of z = f(x, y) [m] over a square of `side` [m] around the origin, as a collider."""
    at = np.linspace(-side / 2, side / 2, n)
    np.save(tmp_path / "hill.npy", f(*np.meshgrid(at, at, indexing="ij")).astype(np.float32))
    return f'[[colliders]]\nshape = "terrain"\nfile = "hill.npy"\nsize = [{side}, {side}]\n'


def bump(x, y):
    return 0.4 * np.sin(2 * x) * np.cos(1.5 * y)


@pytest.mark.parametrize(("ground", "height"), [("slope", lambda x, y: 0.3 + 0.5 * x), ("map", bump)])
@pytest.mark.parametrize("shape", ["size = [1.6, 1.2]", f"outline = {L}"])
def test_depth_is_upright_and_volume_that_of_the_flat_layer(load_text, tmp_path, ground, height, shape):
    """All snow is between h and h + depth, up to h at its columns; V = area x depth, to rounding."""
    colliders = SLOPE if ground == "slope" else map_of(tmp_path, height)
    scene = load_text(f"{shape}\ndepth = 0.25", colliders, dx=0.08)
    _, state, _ = build(scene)
    x = np.asarray(state.x, np.float64)
    above = x[:, 2] - height(x[:, 0], x[:, 1])
    error = 3e-6 if ground == "slope" else 2e-3  # bilinear between samples: (h'' / 8) 0.05^2 < 1.1e-3, twice
    assert above.min() > -error
    assert above.max() < 0.25 + error
    assert np.quantile(above, 0.02) < 0.04
    assert np.quantile(above, 0.98) > 0.21
    area = 1.6 * 1.2 if "size" in shape else 3.0
    assert np.asarray(state.V0, np.float64).sum() == pytest.approx(area * 0.25, rel=1e-6)
    assert np.asarray(state.m, np.float64).sum() == pytest.approx(400 * area * 0.25, rel=1e-6)


def test_base_lifts_and_the_highest_ground_counts(load_text):
    """Over two planes that meet in a valley the layer follows the higher one, `base` above it."""
    valley = SLOPE + SLOPE.replace("-0.5", "0.5")
    _, state, _ = build(load_text("size = [2, 1]\ndepth = 0.2\nbase = 0.1", valley))
    x = np.asarray(state.x, np.float64)
    above = x[:, 2] - (0.3 + 0.5 * np.abs(x[:, 0]))
    assert 0.1 - 3e-6 < above.min() < 0.14
    assert 0.26 < above.max() < 0.3 + 3e-6


def test_turned_map_is_followed(load_text, tmp_path):
    """A map turned by 20 degrees about y: the snow touches the ground of the core everywhere."""
    ground = map_of(tmp_path, lambda x, y: 0.1 * np.sin(3 * x)) + "rotation = [0, 20, 0]\n"
    scene = load_text("size = [1, 1]\ndepth = 0.2", ground)
    model, state, _ = build(scene)
    x = np.array(state.x, np.float64)
    assert model.distance(0, x).min() > -3e-6
    x[:, 2] -= 0.2
    assert model.distance(0, x).max() < 3e-6


def test_overlaps_are_those_of_the_lifted_layer(load_text):
    """A second layer on the first touches it; one half as high shares half of it; a cut leaves that out."""
    second = '[[sources]]\nshape = "layer"\non = "terrain"\nsize = [1, 1]\ndepth = 0.2\n'
    layer = "size = [1, 1]\ndepth = 0.2"
    build(load_text(layer, f"{second}base = 0.2\n{SLOPE}"))
    half = f"{second}base = 0.1\n"
    with pytest.warns(SceneWarning, match=r"overlaps sources\.0 in 0\.1 m3"):
        build(load_text(layer, half + SLOPE))
    _, state, births = build(load_text(layer, f'{half}overlap = "cut"\n{SLOPE}'))
    x = np.asarray(state.x, np.float64)[births.table[1, 0] :]
    assert (x[:, 2] - (0.3 + 0.5 * x[:, 0])).min() > 0.2 - 3e-6


def test_what_stands_in_the_layer_stays_free(load_text):
    """A mesh that stands on the slope in the snow: none of it starts inside."""
    post = '[[colliders]]\nshape = "mesh"\nfile = "neve:hare"\ncenter = [0, 0, 0.3]\n'
    scene = load_text("size = [2, 2]\ndepth = 0.3", SLOPE + post)
    with pytest.warns(match="inside"):
        model, state, _ = build(scene)
    x = np.array(state.x, np.float64)
    assert model.distance(1, x).min() > -1e-3  # a hundredth of dx
    assert len(x) > 0


def test_snow_thrown_on_terrain_while_it_runs(load_text):
    """`Simulation.add` lays a layer on the ground as well."""
    scene = load_text("size = [1, 1]\ndepth = 0.1", SLOPE)
    sim = Simulation(scene)
    before = sim.count
    sim.add(scene.sources[0].model_copy(update={"base": 0.5}))
    x = np.asarray(sim.state.x)[np.asarray(sim.state.id) >= before]
    assert (x[:, 2] - (0.3 + 0.5 * x[:, 0])).min() > 0.5 - 3e-6


@pytest.mark.parametrize(
    ("layer", "colliders", "told"),
    [
        ("depth = 0.1", '[[colliders]]\nshape = "box"\n', r"sources\.0\.on .*needs ground"),
        ("outline = [[0,0],[1,0]]", SLOPE, r"sources\.0\.outline.* 3 to 1000 corners"),
        ("outline = [[0,0],[1,1],[1,0],[0,1]]", SLOPE, "crosses itself"),
        ("outline = [[0,0],[1,1],[2,2]]", SLOPE, "must have an area"),
    ],
)
def test_wrong_layers_are_told(load_text, layer, colliders, told):
    """One sentence with the key."""
    with pytest.raises(SceneError, match=told):
        load_text(layer, colliders)


def test_a_wall_is_no_ground(load_text):
    """On an upright plane nothing lies."""
    with pytest.raises(SceneError, match="finds a wall"):
        build(load_text("depth = 0.1", SLOPE.replace("[-0.5, 0, 1]", "[1, 0, 0]")))


def test_polygons():
    """Area and inside of an L and a spiral by counting; crossings of a bow tie, none of what only touches."""
    corners = np.array(L, float)
    assert area_of(corners + 1e6) == pytest.approx(3.0)
    assert area_of(corners[::-1]) == 3.0
    rng = np.random.default_rng(3)
    x = rng.uniform(-1.5, 1.5, (2000, 2))
    inside = (np.abs(x) < 1).all(axis=1) & ~((x > 0).all(axis=1))
    np.testing.assert_array_equal(holds(corners, x), inside)
    assert crossing(corners) is None
    assert crossing(np.array([[0, 0], [1, 1], [1, 0], [0, 1]], float)) == (0, 2)
