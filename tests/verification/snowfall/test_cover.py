"""Snow that lies: where all of it has gone, its surface, and its particles."""

import numpy as np
import pytest
from pydantic import ValidationError
from verification.snowfall.surfaces import box, ground, plate

import neve
from neve import _core
from neve.build import placed_at_start
from neve.run.snowfall import snow_on
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Numerics, Scene, Source
from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.cover import MOST_FLAKES, Raster, let_fall
from neve.snowfall.filling import depth_below_top
from neve.snowfall.scene import Falls
from neve.snowfall.skin import LIP, skin
from neve.snowfall.surroundings import joined

HOUSE = [
    ground(),
    box((-0.5, -0.5, 0.0), (0.5, 0.5, 1.0)),
    plate("roof", "sheet", -1.0, 1.0, -1.0, 1.0, 1.5, (0.6, 0.0)),
]


def fallen(pieces=HOUSE, cell=0.1, size=(4.0, 4.0), **keys):
    """The cover of a fall on `pieces`."""
    fall = Snowfall(size=size, **{"depth": 0.2, "flutter": 0.2, **keys})
    return let_fall(fall, joined(pieces), Raster.over((0.0, 0.0), size, cell))


def test_books_close():
    """What fell lies, missed or slid away, to rounding; what walls keep off and the error are below 2 %."""
    books = fallen().books
    assert books.settled
    assert abs(books.fell - books.lies - books.missed - books.slid) < 1e-12
    assert books.fell == pytest.approx(0.2 * 16.0, rel=1e-12)
    assert abs(books.missed) < 0.02 * books.fell
    assert books.over_edges > 0.0


def test_open_ground_is_as_deep_as_stated():
    """A rate R [mm/h] for a time t lies R t / rho deep, rho = 109 + 6 T + 26 sqrt(u), on open ground."""
    cover = fallen([ground()], depth=None, rate=2.0, duration=5.0, temperature=-4.0, wind=(4.0, 0.0))
    rho = 109.0 - 24.0 + 52.0
    assert np.abs(cover.depth - 2.0 * 5.0 / rho).max() < 1e-12
    assert np.all(cover.layers.density == rho)


def half_covered(seed, tolerance):
    """The share that reaches each place of a plane in the rough of half a roof, and the flakes it took."""
    roof = plate("roof", "sheet", -50.0, 0.0, -50.0, 50.0, 3.0)
    keys = {"depth": 0.1, "flutter": 0.4, "steps": 1, "stability": "none", "cell": 0.25, "size": (2.0, 2.0)}
    cover = fallen([ground(), roof], seed=seed, tolerance=tolerance, **keys)
    return cover.depth[cover.columns.part() == 0] / 0.1, cover.books.flakes, len(cover.depth)


@pytest.mark.parametrize("tolerance", [0.1, 0.02, 1e-4])
def test_error_follows_the_tolerance_down_to_that_of_the_most_flakes(tolerance):
    """Of 4096 flakes the standard error is 0.5 / 64 at most: below it a tolerance gets no more of them.

    So two falls with other flakes differ by sqrt(2) of that on average; 1.5 times as much is allowed.
    """
    one, flakes, places = half_covered(1, tolerance)
    other, _, _ = half_covered(2, tolerance)
    reached = max(tolerance, 0.5 / np.sqrt(MOST_FLAKES))
    assert np.sqrt(np.mean((one - other) ** 2)) <= 1.5 * np.sqrt(2.0) * reached
    assert flakes <= MOST_FLAKES * places
    assert (flakes > 0.2 * MOST_FLAKES * places) == (tolerance < reached)


def test_same_bits_on_any_number_of_threads():
    """Parts, slides, layers and drift of a fall: all of it, on 1, 2 and 5 threads."""
    keys = {"cell": 0.2, "steps": 3, "drift": 0.2, "drift_wind": (10.0, 3.0), "tolerance": 0.1}
    before, found = _core.threads(), []
    for threads in (1, 2, 5):
        _core.set_threads(threads)
        found.append(fallen(**keys))
    _core.set_threads(before)
    first, *others = found
    assert first.books.over_edges > 0.0
    for other in others:
        assert other.books == first.books
        assert np.array_equal(other.depth, first.depth)
        assert np.array_equal(other.share, first.share)
        layers = first.layers.arrays()
        assert all(np.array_equal(values, layers[name]) for name, values in other.layers.arrays().items())


def test_surface_is_closed_and_holds_the_snow():
    """Caps and flakes have no open edge; their volume is that of the snow within 3 %, and lips.

    Half an ellipse d high and LIP d wide is pi/4 LIP d^2 a metre of edges: 8 of the roof, 4 of the box.
    """
    cover = fallen()
    surface = skin(cover)
    assert surface.open_edges == 0
    roof, top = (cover.depth[cover.columns.part() == k].max() for k in (2, 1))
    lips = np.pi / 4 * LIP * (8.0 * roof**2 + 4.0 * top**2)
    assert -0.03 <= surface.volume / cover.books.lies - 1.0 <= 0.03 + lips / cover.books.lies
    assert surface.high[2] < 2.4


def test_lips_hang_over_edges():
    """A cap on a table is wider than the table, and its side is round."""
    surface = skin(fallen([plate("table", "sheet", -0.5, 0.5, -0.5, 0.5, 1.0)], size=(2.0, 2.0), repose=80.0))
    assert 0.52 < surface.high[0] < 0.62


def test_later_parts_see_earlier_snow():
    """Snow that reaches the underside of a table leaves no room for more: depths stay below the ceiling."""
    cover = fallen([ground(), box((-5, -5, 0.03), (0, 5, 0.2))], depth=0.5, flutter=1.0, stability="none")
    room = cover.columns.ceiling() - cover.z
    assert np.all(cover.depth <= room)
    assert np.any(np.isclose(cover.depth, room))


@pytest.mark.parametrize(
    ("scene", "own", "lies"),
    [
        ({}, {}, True),
        ({"kind": "icy"}, {}, True),
        ({"kind": "slush"}, {}, False),
        ({"kind": "slush"}, {"repose": 42.0}, True),
        ({"kind": "slush"}, {"snow": {"kind": "icy"}}, True),
        ({"kind": "icy"}, {"snow": {"kind": "slush"}}, False),
    ],
)
def test_angle_of_repose_follows_the_kind(scene, own, lies):
    """On a slope of 30 degrees grains of ice (42) and new snow (50) stay; slush (15) slides to the lower rim.

    There it is a wedge of the length L, with L^2 (tan 30 - tan 15) / 2 of snow: 0.1 m times 2 m.
    """
    plane = {"shape": "plane", "normal": [-1.0, 0.0, 3.0**0.5]}
    fall = {"shape": "snowfall", "depth": 0.1, "flutter": 0.0, "cell": 0.1, **own}
    built = scene_from({"snow": scene, "sources": [fall], "colliders": [plane]})
    cover = Falls(built, placed_at_start(built)).fallen(0)
    assert cover.books.settled
    depth = cover.depth.reshape(cover.raster.nx, cover.raster.ny)
    if lies:
        assert np.allclose(depth, 0.1, atol=1e-12)
        return
    rise = np.diff(cover.x[:, 2].reshape(depth.shape), axis=0)[depth[1:] > 1e-6] / cover.raster.cell
    assert rise.max() <= np.tan(np.radians(15.0)) + 0.001
    length = np.sqrt(2.0 * 0.1 * 2.0 / (np.tan(np.radians(30.0)) - np.tan(np.radians(15.0))))
    assert np.all(np.abs(np.sum(depth > 1e-3, axis=0) * cover.raster.cell - length) <= cover.raster.cell)


def test_particles_are_the_snow():
    """Particles lie in the snow, with its volume and the density of new snow; equal scenes, equal bits."""
    scene = Scene(
        numerics=Numerics(dx=0.1),
        sources=(Source.of("snowfall", depth=0.3, size=(3.0, 3.0), density=120.0),),
        colliders=scene_from({"sources": [{"shape": "box"}], "colliders": [{"shape": "plane"}]}).colliders,
    )
    state = neve.Simulation(scene).state
    assert state.m.sum() == pytest.approx(120.0 * 0.3 * 9.0, rel=1e-4)
    x = np.asarray(state.x)
    assert x[:, 2].min() > 0.0
    assert x[:, 2].max() < 0.3
    assert np.array_equal(x, np.asarray(neve.Simulation(scene).state.x))


def test_thin_snow_is_scattered():
    """Snow a tenth of a particle deep is a particle on a tenth of the places, and keeps its mass."""
    data = {
        "numerics": {"dx": 0.1},
        "sources": [{"shape": "snowfall", "depth": 0.005, "size": [5.0, 5.0], "density": 100.0}],
        "colliders": [{"shape": "plane"}],
    }
    scene = scene_from(data)
    state = neve.Simulation(scene).state
    places = (5.0 / scene.numerics.spacing) ** 2
    assert state.count == pytest.approx(0.1 * places, rel=0.1)
    assert state.m.sum() == pytest.approx(100.0 * 0.005 * 25.0, rel=1e-4)


def test_falls_lie_on_sources_before_them():
    """A second fall lies on the first one, and both on a block of snow."""
    data = {
        "numerics": {"dx": 0.1},
        "sources": [
            {"shape": "box", "center": [0, 0, 0.5]},
            {"shape": "snowfall", "depth": 0.2, "size": [3.0, 3.0], "density": 100.0},
            {"shape": "snowfall", "depth": 0.2, "size": [3.0, 3.0], "density": 200.0},
        ],
        "colliders": [{"shape": "plane"}],
    }
    state = neve.Simulation(scene_from(data)).state
    x, rho = np.asarray(state.x), np.asarray(state.m) / np.asarray(state.V0)
    over = (np.abs(x[:, :2]) < 0.3).all(axis=1)
    assert 1.15 < x[over & (rho < 150)][:, 2].max() < 1.25
    top = x[over & (rho > 150) & (rho < 250)][:, 2]
    assert top.min() > 1.15
    assert 1.3 < top.max() < 1.45


def test_bodies_that_fly_have_no_snow():
    """Snow lies on a body at rest, not on one that flies by when the run begins, nor in its shadow."""
    body = {"shape": "box", "size": [1.0, 1.0, 0.2], "center": [0.0, 0.0, 1.1]}
    data = {
        "numerics": {"dx": 0.2},
        "sources": [{"shape": "snowfall", "depth": 0.2, "flutter": 0.0}],
        "colliders": [{"shape": "plane"}],
    }
    for velocity, lies in (([0.0, 0.0, 0.0], True), ([3.0, 0.0, 0.0], False)):
        run = neve.Simulation(scene_from({**data, "bodies": [{**body, "velocity": velocity}]}))
        x = np.asarray(run.state.x)
        over = np.all(np.abs(x[:, :2]) < 0.4, axis=1)
        assert np.any(over & (x[:, 2] > 1.2)) == lies
        assert np.any(over & (x[:, 2] < 0.3)) != lies


def test_each_fall_is_counted_once(monkeypatch):
    """Of four falls on one another each is counted once, not anew for those after it."""
    counted = []

    def counting(fall, *others):
        counted.append(fall.seed)
        return let_fall(fall, *others)

    monkeypatch.setattr("neve.snowfall.kept.let_fall", counting)
    data = {
        "numerics": {"dx": 0.2},
        "sources": [{"shape": "snowfall", "depth": 0.2, "steps": 1, "seed": k} for k in range(4)],
        "colliders": [{"shape": "plane"}],
    }
    tops = np.asarray(neve.Simulation(scene_from(data)).state.x)[:, 2]
    assert counted == [0, 1, 2, 3]
    assert 0.7 < tops.max() < 0.8


def test_depth_below_the_top():
    """Points in the snow know how deep they are; others are outside."""
    cover = fallen([ground()], depth=0.3)
    points = np.array([[0.05, 0.05, 0.1], [0.05, 0.05, 0.31], [0.05, 0.05, -0.01], [9.0, 0.0, 0.1]])
    found = depth_below_top(cover, points)
    assert found[0] == pytest.approx(0.2)
    assert np.all(found[1:] < 0.0)


def test_command_writes_a_mesh_of_a_mesh(tmp_path):
    """`neve snow` on a mesh: the files are there, and read back as what lies."""
    import json

    from neve.geometry.files import read

    cover, folder = snow_on("neve:rock", str(tmp_path / "out"), options={"depth": 0.1, "cell": 0.05})
    books = json.loads((folder / "books.json").read_text())
    assert books["lies"] == pytest.approx(cover.books.lies)
    vertices, faces = read(folder / "snow.ply", [])
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert volume == pytest.approx(books["volume_of_mesh"], rel=1e-3)
    assert len((folder / "depth.csv").read_text().splitlines()) == 1 + len(cover.depth)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"depth": -1.0}, "--depth"),
        ({"depth": 1.0, "rate": 1.0}, "--rate"),
        ({"flutter": float("nan")}, "--flutter"),
        ({"drift_wind": (float("inf"), 0.0)}, "--drift-wind"),
        ({"cell": 1e-7}, "--cell"),
    ],
)
def test_wrong_options_are_a_sentence(tmp_path, options, says):
    """Nothing is written, and the option is named."""
    with pytest.raises(SceneError, match=says):
        snow_on("neve:rock", str(tmp_path / "out"), options=options)
    assert not (tmp_path / "out").exists()


def test_a_table_of_that_name_says_where_it_goes():
    """[snowfall] is told to be a source."""
    with pytest.raises(SceneError, match=r"\[\[sources\]\] with shape"):
        scene_from({"snowfall": {"depth": 0.1}, "sources": [{"shape": "box"}]})
    with pytest.raises(ValidationError, match="snowfall"):
        Scene.model_validate({"snowfall": {}})


@pytest.mark.parametrize(
    ("keys", "density", "depth"),
    [
        ({"temperature": -5.0}, 109.0 - 30.0, 0.1),
        ({"temperature": 0.0, "wind": (3.0, -4.0)}, 109.0 + 26.0 * 5.0**0.5, 0.1),
        ({"temperature": -20.0}, 50.0, 0.1),
        ({"rate": 2.0, "duration": 12.0, "density": 80.0}, 80.0, 0.3),
    ],
)
def test_density_and_depth_of_new_snow(keys, density, depth):
    """Pahaut's 109 + 6 T + 26 sqrt(u), 50 at least; 2 mm of water in an hour are 2 kg on a square metre."""
    fall = Snowfall(**keys)
    assert fall.new_density == pytest.approx(density)
    assert fall.open_depth == pytest.approx(depth)
