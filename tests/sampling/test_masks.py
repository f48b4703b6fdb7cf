"""Layers whose place a picture or a raster says."""

import numpy as np
import pytest
import tiffs
from PIL import Image
from tiffs import geo

from neve.io.assets import assets_of, keep_assets, portable
from neve.mpm.initial import build
from neve.sampling import fill
from neve.scene.errors import SceneError
from neve.scene.reading.load import load, scene_from
from neve.viewer.tools.panel import panel

RHO0 = 400.0
EAST, NORTH = 500_000.0, 5_100_000.0


@pytest.fixture
def snow_of(tmp_path):
    """Read a scene of a layer with the mask "mask.*" and build it: positions, masses."""

    def read(layer, colliders="", dx=0.1):
        (path,) = tmp_path.glob("mask.*")
        head = f'[numerics]\ndx = {dx}\n[[sources]]\nshape = "layer"\nmask = "{path.name}"\n'
        (tmp_path / "scene.toml").write_text(f"{head}{layer}\n{colliders}", encoding="utf-8")
        _, state, _ = build(load(tmp_path / "scene.toml"))
        return np.asarray(state.x, np.float64), np.asarray(state.m, np.float64)

    return read


def terrain(tmp_path, keys="", code=32632):
    """A GeoTIFF of a slope z = x + 2 from -2 to 2 m, of 41 x 41 samples, as a collider."""
    rows = np.broadcast_to(0.1 * np.arange(41), (41, 41)).astype("f4")
    system = {1024: 1, 1025: 1, 3072: code, 3076: 9001}
    tiffs.write(tmp_path / "ground.tif", rows, tags=geo((0.1, 0.1), system, corner=(EAST, NORTH + 4.1)))
    return f'[[colliders]]\nshape = "terrain"\nfile = "ground.tif"\n{keys}\n'


def disk(n, radius, side):
    """Rows from the top of an n x n picture of `side`, true within `radius` of its middle."""
    at = np.linspace(-0.5, 0.5, n) * side
    return np.hypot(*np.meshgrid(at, at)) < radius


@pytest.mark.parametrize("n", [51, 401])
@pytest.mark.parametrize("dx", [0.1, 0.05])
def test_mass_of_a_disk(snow_of, tmp_path, n, dx):
    """Area x depth x density: of the cells to rounding, of the circle to the error of its staircase.

    A staircase of cells of side h misses about N^(1/3) of N = pi r^2 / h^2 cells (Gauss's circle problem).
    """
    picture = disk(n, 0.8, 2.0)
    Image.fromarray((255 * picture).astype(np.uint8)).save(tmp_path / "mask.png")
    x, m = snow_of("size = [2, 2]\ndepth = 0.2\ncenter = [3, 1]", dx=dx)
    cells = np.count_nonzero(picture)
    h = 2.0 / (n - 1)
    assert m.sum() == pytest.approx(cells * h * h * 0.2 * RHO0, rel=1e-6)
    assert abs(cells * h * h - np.pi * 0.64) < 3 * h * h * cells ** (1 / 3)
    far = np.hypot(x[:, 0] - 3, x[:, 1] - 1)
    assert 0.8 - dx < far.max() < 0.8 + h
    assert x[:, 2].min() >= 0
    assert x[:, 2].max() <= 0.2


@pytest.mark.parametrize("ending", ["png", "asc", "npy", "tif", "turned.tif"])
def test_north_is_up(snow_of, tmp_path, ending):
    """Snow in the north-east alone: the last columns of the first rows; of arrays, the last of both axes."""
    rows = np.zeros((20, 30), np.uint8)
    rows[:5, 24:] = 1
    pixel = geo((0.1, 0.1), corner=(EAST, NORTH))
    if ending == "png":
        Image.fromarray(rows).save(tmp_path / "mask.png")
    elif ending == "asc":
        lines = "\n".join(" ".join(map(str, row)) for row in rows.tolist())
        head = f"ncols 30\nnrows 20\nxllcorner {EAST}\nyllcorner {NORTH}\ncellsize 0.1\n"
        (tmp_path / "mask.asc").write_text(head + lines, encoding="utf-8")
    elif ending == "npy":
        np.save(tmp_path / "mask.npy", rows[::-1].T > 0)
    elif ending == "tif":
        tiffs.write(tmp_path / "mask.tif", rows, tags=pixel)
    else:  # from south to north: Y grows with the row
        south = geo(matrix=(0.1, 0.0, 0.0, 0.1), corner=(EAST, NORTH))
        tiffs.write(tmp_path / "mask.tif", rows[::-1], tags=south)
    x, m = snow_of("size = [2.9, 1.9]\ndepth = 0.2", dx=0.05)
    own = ending in (
        "asc",
        "tif",
        "turned.tif",
    )  # these have cells of 0.1 m, others samples from edge to edge
    low, high = ((0.9, 0.5), (1.5, 1.0)) if own else ((0.9, 0.5), (1.45, 0.95))
    assert m.sum() == pytest.approx(np.prod(np.subtract(high, low)) * 0.2 * RHO0, rel=1e-6)
    np.testing.assert_allclose(x[:, :2].min(axis=0), low, atol=0.02)
    np.testing.assert_allclose(x[:, :2].max(axis=0), high, atol=0.02)
    assert (x[:, :2] > np.array(low) - 1e-6).all()
    assert (x[:, :2] < np.array(high) + 1e-6).all()


@pytest.mark.parametrize("turn", [0.0, 30.0])
@pytest.mark.parametrize("point", [False, True])
def test_coordinates_place_a_mask_on_terrain(snow_of, tmp_path, turn, point):
    """Cells of 0.25 m, by the coordinates of both files, on a map of 4 m around (5, -3), turned by the scene.

    A pixel of the mask that is a point has its coordinates in its middle: half a cell to the north-west.
    """
    rows = np.zeros((8, 8), np.uint8)
    rows[1, 6] = 1  # 1.5 to 1.75 m east and 0.25 to 0.5 m south of the mask's corner
    keys = {1024: 1, 1025: 2 if point else 1, 3072: 32632, 3076: 9001}
    tags = geo((0.25, 0.25), keys, corner=(EAST + 2.0, NORTH + 3.0))
    tiffs.write(tmp_path / "mask.tif", rows, tags=tags)
    ground = terrain(tmp_path, f"center = [5, -3, 0]\nrotation = [0, 0, {turn}]")
    x, m = snow_of('on = "terrain"\ndepth = 0.3', ground, dx=0.04)
    assert m.sum() == pytest.approx(0.25**2 * 0.3 * RHO0, rel=1e-6)
    shift = np.array([-0.125, 0.125]) if point else np.zeros(2)
    middle = np.array([3.625, 2.625]) + shift - 0.5 * 0.1 * 41  # from the middle of the ground
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    local = (x[:, :2] - [5, -3]) @ np.array([[c, -s], [s, c]])
    assert (np.abs(local - middle) < 0.125 + 1e-6).all()
    np.testing.assert_allclose(np.ptp(local, axis=0), 0.25, atol=0.04)
    above = x[:, 2] - (local[:, 0] + 2.0)  # samples at 0, 0.1 ... 4.0 m, from the western edge
    assert -1e-4 < above.min() < 0.03
    assert 0.27 < above.max() < 0.3 + 1e-4


def test_degrees_count_on_terrain_in_degrees(snow_of, tmp_path):
    """Half of its width and a quarter of its height, of a map of 40 m by 20 m that `size` says."""
    keys = {1024: 2, 1025: 1, 2048: 4326}
    ground = geo((0.001, 0.001), keys, corner=(8.9995, 46.0105))  # samples from 9.0 to 9.04, 45.99 to 46.01
    tiffs.write(tmp_path / "ground.tif", np.zeros((21, 41), "f4"), tags=ground)
    rows = np.zeros((4, 4), np.uint8)
    rows[3, :2] = 1  # the quarter in the south, the half in the west
    tiffs.write(tmp_path / "mask.tif", rows, tags=geo((0.01, 0.005), keys, corner=(9.0, 46.01)))
    collider = '[[colliders]]\nshape = "terrain"\nfile = "ground.tif"\nsize = [40, 20]\n'
    x, m = snow_of('on = "terrain"\ndepth = 0.5', collider, dx=0.25)
    assert m.sum() == pytest.approx(20.0 * 5.0 * 0.5 * RHO0, rel=1e-5)
    np.testing.assert_allclose(x[:, :2].min(axis=0), [-20, -10], atol=0.1)
    np.testing.assert_allclose(x[:, :2].max(axis=0), [0, -5], atol=0.1)


def test_a_turned_raster_lies_turned(snow_of, tmp_path):
    """A raster of 2 m by 1 m whose columns run 30 degrees north of east; without terrain, around `center`."""
    c, s = 0.1 * np.cos(np.radians(30)), 0.1 * np.sin(np.radians(30))
    tiffs.write(tmp_path / "mask.tif", np.ones((10, 20), "u1"), tags=geo(matrix=(c, s, s, -c)))
    x, m = snow_of("depth = 0.2\ncenter = [3, 0]", dx=0.05)
    assert m.sum() == pytest.approx(2.0 * 0.2 * RHO0, rel=1e-6)
    along = (x[:, :2] - [3, 0]) @ (np.array([[c, -s], [s, c]]) / 0.1)
    np.testing.assert_allclose(np.abs(along).max(axis=0), [1.0, 0.5], atol=0.02)


def test_a_picture_is_stretched_over_terrain(snow_of, tmp_path):
    """White in its upper half: north of the middle sample, wherever the layer's center is."""
    picture = np.zeros((9, 9, 3), np.uint8)
    picture[:4] = 250
    Image.fromarray(picture).save(tmp_path / "mask.png")
    x, m = snow_of('on = "terrain"\ndepth = 0.2', terrain(tmp_path))
    assert m.sum() == pytest.approx(4.0 * 3.5 * 0.5 * 0.2 * RHO0, rel=1e-6)  # 3.5 of 8 steps of 0.5 m
    assert x[:, 1].min() == pytest.approx(2.0 - 1.75, abs=0.05)
    assert x[:, 0].min() == pytest.approx(-2.0, abs=0.05)


def test_outline_and_mask_intersect(snow_of, tmp_path):
    """Half of a full mask: the triangle's area, to the lattice that measures it."""
    np.save(tmp_path / "mask.npy", np.ones((50, 50)))
    x, m = snow_of("outline = [[-1, -1], [1, -1], [1, 1]]\ndepth = 0.2")
    assert m.sum() == pytest.approx(2.0 * 0.2 * RHO0, rel=2e-3)
    assert (x[:, 1] <= x[:, 0]).all()


def test_a_mask_beyond_the_terrain_is_cut(snow_of, tmp_path):
    """A mask of 8 m on a map of 4 m: its snow lies on the map alone."""
    tags = geo((1.0, 1.0), corner=(EAST - 2.0, NORTH + 6.0))
    tiffs.write(tmp_path / "mask.tif", np.ones((8, 8), "u1"), tags=tags)
    x, m = snow_of('on = "terrain"\ndepth = 0.2', terrain(tmp_path))
    assert m.sum() == pytest.approx(16.0 * 0.2 * RHO0, rel=2e-3)
    assert (np.abs(x[:, :2]) <= 2.0 + 1e-5).all()


def test_depth_in_metres_and_missing_numbers(snow_of, tmp_path):
    """A wedge from 0 to 0.5 m in metres, `depth` 1: half of it below the mean; none where numbers miss."""
    n = 21
    rows = np.broadcast_to(np.linspace(0.0, 0.5, n), (n, n)).astype("f4").copy()
    rows[:10] = -9999.0
    tags = geo((0.1, 0.1), corner=(EAST, NORTH)) | {42113: (tiffs.ASCII, "-9999")}
    tiffs.write(tmp_path / "mask.tif", rows, tags=tags)
    x, m = snow_of('mask_means = "depth"\ndepth = 1', dx=0.05)
    assert m.sum() == pytest.approx(11 * n * 0.01 * 0.25 * RHO0, rel=1e-6)
    limit = np.clip(0.25 + 0.25 * x[:, 0], 0.0, 0.5)  # bilinear between the middles of the cells
    assert (x[:, 2] <= limit + 1e-6).all()
    assert x[:, 1].max() < 0.1
    assert 0.45 < x[:, 2].max() <= 0.5
    west = m[x[:, 0] < 0].sum()
    assert west / m.sum() == pytest.approx(0.25, abs=0.02)


def test_grey_pictures_as_cover_and_as_depth(snow_of, tmp_path):
    """Cover: above half of the brightest, 200; depth: the share of 255."""
    Image.fromarray(np.array([[90, 110], [110, 200]], np.uint8)).save(tmp_path / "mask.png")
    _, m = snow_of("depth = 0.2")
    assert m.sum() == pytest.approx(3.0 * 0.2 * RHO0, rel=1e-6)
    _, m = snow_of('mask_means = "depth"\ndepth = 0.5')
    assert m.sum() == pytest.approx((90 + 110 + 110 + 200) / 255 * 0.5 * RHO0, rel=1e-6)


def test_what_is_transparent_is_not_set(snow_of, tmp_path):
    """A red picture with a hole."""
    picture = np.full((3, 3, 4), 255, np.uint8)
    picture[..., 1:3] = 0
    picture[1, 1, 3] = 0
    Image.fromarray(picture).save(tmp_path / "mask.png")
    _, m = snow_of("depth = 0.2")
    assert m.sum() == pytest.approx(3.0 * 0.2 * RHO0, rel=1e-6)  # 2 m: the middle cell of 1 m is missing


@pytest.mark.parametrize("ending", ["png", "tif"])
def test_black_and_white(snow_of, tmp_path, ending):
    """Numbers of one bit: the middle cell of 1 m is set, of a width that fills no byte."""
    rows = np.zeros((3, 3), bool)
    rows[1, 1] = True
    if ending == "png":
        Image.fromarray(rows).save(tmp_path / "mask.png")
    else:
        tiffs.write(tmp_path / "mask.tif", rows)
    _, m = snow_of("depth = 0.2")
    assert m.sum() == pytest.approx(1.0 * 0.2 * RHO0, rel=1e-6)


@pytest.mark.parametrize(
    ("layer", "values", "told"),
    [
        ("depth = 0.1", np.zeros((4, 4)), "has nothing set"),
        ('mask_means = "depth"', np.full((4, 4), -1.0), "negative depths, down to -1"),
        ('mask_means = "depth"', np.full((4, 4), np.nan), "no depth above 0"),
        ("outline = [[5, 5], [6, 5], [6, 6]]", np.tri(4), r"does not overlap sources\.0\.outline"),
        ("depth = 0.1", np.ones(9), "two axes"),
    ],
)
def test_wrong_masks_are_told(snow_of, tmp_path, layer, values, told):
    """One sentence that begins with the key and the file."""
    np.save(tmp_path / "mask.npy", values)
    ground = terrain(tmp_path) if "outline" in layer else ""
    on = 'on = "terrain"\n' if ground else ""
    with pytest.raises(SceneError, match=rf"sources\.0\.mask = .*mask\.npy.* {told}"):
        snow_of(on + layer, ground)


def test_a_mask_elsewhere_is_told(snow_of, tmp_path):
    """Beside the terrain, in another system, and on a map that lies on its side."""
    far = geo((0.5, 0.5), corner=(EAST + 900.0, NORTH))
    tiffs.write(tmp_path / "mask.tif", np.ones((4, 4), "u1"), tags=far)
    with pytest.raises(SceneError, match=r"sources\.0\.mask = .* does not overlap colliders\.0"):
        snow_of('on = "terrain"', terrain(tmp_path))
    with pytest.raises(SceneError, match=r"EPSG:32632\) than the terrain \(EPSG:2056\)"):
        snow_of('on = "terrain"', terrain(tmp_path, code=2056))
    with pytest.raises(SceneError, match=r"colliders\.0\.rotation"):
        snow_of('on = "terrain"', terrain(tmp_path, "rotation = [0, 20, 0]"))


def test_a_mask_goes_with_its_run(tmp_path):
    """A copy with its coordinates lies in the run folder, whose scene has the same snow; the panel has it."""
    lines = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0.5\n1 0\n1 1\n"
    (tmp_path / "mask.asc").write_text(lines, encoding="utf-8")
    (tmp_path / "mask.prj").write_text('PROJCS["a",GEOGCS["b"],UNIT["Meter",1.0]]', encoding="utf-8")
    scene = scene_from({"sources": [{"shape": "layer", "mask": "mask.asc"}]}, folder=tmp_path)
    run, assets = tmp_path / "run", assets_of(scene)
    keep_assets(run, assets)
    (run / "scene.toml").write_text(portable(scene, assets), encoding="utf-8")
    copy = load(run)
    assert copy.sources[0].mask.startswith(str(run / "assets"))
    found = [fill(one.sources[0], one.numerics, 0).x for one in (scene, copy)]
    np.testing.assert_array_equal(*found)
    shown = {field["path"]: field for section in panel(scene) for field in section["fields"]}
    assert shown["sources.0.mask"]["choices"] == ["", scene.sources[0].mask]


def test_keys_of_masks(tmp_path):
    """Other endings, depth without a mask, and a file that is not there."""
    for layer, told in (
        ('mask = "a.jpg"', "must end in"),
        ('mask_means = "depth"', "needs a mask"),
        ('mask = "a.png"', "is not a file"),
    ):
        (tmp_path / "scene.toml").write_text(f'[[sources]]\nshape = "layer"\n{layer}\n', encoding="utf-8")
        with pytest.raises(SceneError, match=told):
            load(tmp_path / "scene.toml")
