"""GeoTIFFs of every kind: the same heights, however the file holds them, or a refusal by the true name."""

from __future__ import annotations

import warnings
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tiffs
from PIL import Image
from tiffs import ASCII, DOUBLE, SHORT, geo, heights

from neve.geometry.maps.tiff import read_tiff
from neve.geometry.terrain import height_field
from neve.scene.errors import SceneError, SceneWarning
from neve.scene.schema.scene import Collider

NAME = "colliders.0"


def ground(path: str, **keys: Any) -> tuple[Any, list[str]]:
    """Return the heights at the corners SW, NW, SE, NE with the size, and what is warned of."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        field = height_field(Collider.of("terrain", file=path, **keys), NAME)
    x, y = 0.5 * np.array(field.size)
    corners = np.array([[-x, -y, 0.0], [-x, y, 0.0], [x, -y, 0.0], [x, y, 0.0]])
    phi, normal = field.sample(corners)
    assert all(one.category is SceneWarning for one in heard)
    found = np.array([*(-np.asarray(phi) / np.asarray(normal)[:, 2]), *field.size])
    return found, [str(one.message) for one in heard]


CORNERS = (100.0, 195.0, 158.0, 253.0, 290.0, 190.0)
"""Of `heights()` with pixels of 10 m."""


@pytest.mark.parametrize("kind", ["u1", "u2", "u4", "u8", "i1", "i2", "i4", "i8", "f2", "f4", "f8"])
def test_numbers_are_the_same_however_they_are_packed(kind: str, tmp_path: Path) -> None:
    """Both orders of bytes, strips and tiles, six compressions and the predictors: every number, exactly."""
    rng = np.random.default_rng(7)
    whole = rng.integers(0, 120, (23, 37)) - (60 if kind[0] == "i" else 0)
    rows = whole.astype(kind) if kind[0] != "f" else rng.normal(1000.0, 400.0, (23, 37)).astype(kind)
    predictors = (1, 2, 3) if kind[0] == "f" else (1, 2)
    choices = product("<>", (1, 5, 8, 32773, 34925, 50000), predictors, (None, (16, 32)), (False, True))
    for order, compression, predictor, tile, big in choices:
        if (big or kind not in ("f4", "i2")) and compression not in (1, 5):  # each by itself is enough
            continue
        path = tiffs.write(
            tmp_path / "a.tif",
            rows,
            order=order,
            compression=compression,
            predictor=predictor,
            tile=tile,
            big=big,
        )
        found = read_tiff(Path(path), "it").values
        assert np.array_equal(found, rows[::-1].T.astype(np.float64)), (order, compression, predictor, tile)


@pytest.mark.parametrize(
    ("kind", "more", "keys"),
    [
        ("f4", {"order": ">", "compression": 5}, {}),
        ("f8", {}, {}),
        ("u2", {"planar": 2}, {"height": 65535.0}),
        ("i2", {"planar": 2, "tile": (16, 16)}, {"height": 65535.0}),
    ],
)
def test_known_heights(kind: str, more: dict[str, Any], keys: dict[str, Any], tmp_path: Path) -> None:
    """Least 100 m in the south-west, largest 253 m in the north-east, 29 x 19 pixels of 10 m."""
    path = tiffs.write(tmp_path / "map.tif", heights().astype(kind), tags=geo(), **more)
    found, said = ground(path, **keys)
    assert found == pytest.approx(CORNERS, abs=2e-3)
    assert said == []


def test_numbers_below_zero_of_eight_bits(tmp_path: Path) -> None:
    """int8 from -15 to 23 stay below zero: 255 m of full range are 1 m a unit."""
    rows = (heights() / 4.0 - 40.0).round().astype(np.int8)
    path = tiffs.write(tmp_path / "map.tif", rows, tags=geo())
    found, _ = ground(path, height=255.0)
    assert found[:4] == pytest.approx([rows[-1, 0], rows[0, 0], rows[-1, -1], rows[0, -1]], abs=1e-3)
    assert found[:4].min() < 0.0


@pytest.mark.parametrize("word", ["-3.4e+38", "-3.4028234663852886e+38", "-9999", "nan", "-inf", "1e20"])
def test_missing_values_are_compared_in_their_own_type(word: str, tmp_path: Path) -> None:
    """A tag in decimal digits means the number nearest to it in the file's type, in both types of reals."""
    for kind in (np.float32, np.float64):
        rows = heights().astype(kind)
        rows[3, 4] = kind(word)
        path = tiffs.write(tmp_path / "map.tif", rows, tags=geo() | {42113: (ASCII, word)})
        with pytest.raises(SceneError, match=r"has gaps, 1 in all, .*: fill them\.$"):
            ground(path)


def test_missing_values_of_whole_numbers(tmp_path: Path) -> None:
    """-32768 in int16; a value that the type does not have, -9999 in uint8, means none."""
    rows = heights().astype(np.int16)
    rows[0, 0] = -32768
    path = tiffs.write(tmp_path / "map.tif", rows, tags=geo() | {42113: (ASCII, "-32768.0")})
    with pytest.raises(SceneError, match="has gaps, 1 in all"):
        ground(path, height=65535.0)
    path = tiffs.write(tmp_path / "b.tif", heights().astype(np.uint8), tags=geo() | {42113: (ASCII, "-9999")})
    assert ground(path, height=255.0)[0] == pytest.approx(CORNERS, abs=1e-3)


def test_missing_values_without_a_tag(tmp_path: Path) -> None:
    """Numbers that no height is are gaps; numbers that often stand for gaps are warned of."""
    rows = heights().astype(np.float32)
    rows[3, 4] = -3.4e38
    with pytest.raises(
        SceneError, match=r"gaps, 1 in all, where numbers such as -3.4e\+38 stand for missing"
    ):
        ground(tiffs.write(tmp_path / "a.tif", rows, tags=geo()))
    rows[3, 4] = -9999.0
    _, said = ground(tiffs.write(tmp_path / "b.tif", rows, tags=geo()), size=(1e4, 1e4))
    assert len(said) == 1
    assert "has the height -9999 at 1 of 600 places" in said[0]


def test_masks_and_transparency_are_gaps(tmp_path: Path) -> None:
    """A mask of one bit a pixel, and a second channel of transparency, side by side and apart."""
    rows = heights().astype(np.float32)
    clear = np.ones(rows.shape, dtype=bool)
    clear[2, 3:5] = False
    for compression in (1, 5, 8):
        path = tiffs.write(tmp_path / "a.tif", rows, tags=geo(), mask=clear, compression=compression)
        with pytest.raises(SceneError, match="has gaps, 2 in all"):
            ground(path)
    both = np.stack([rows, np.where(clear, 255.0, 0.0)], axis=-1).astype(np.float32)
    for planar in (1, 2):
        path = tiffs.write(tmp_path / "b.tif", both, tags=geo() | {338: (SHORT, 2)}, planar=planar)
        with pytest.raises(SceneError, match="has gaps, 2 in all"):
            ground(path)
    whole = tiffs.write(tmp_path / "c.tif", rows, tags=geo(), mask=np.ones_like(clear), compression=8)
    assert ground(whole)[0] == pytest.approx(CORNERS, abs=1e-3)


FEET = 1200.0 / 3937.0


@pytest.mark.parametrize(
    ("keys", "flat", "high", "doubts"),
    [
        ({1024: 1, 3072: 2277, 3076: 9003}, FEET, 1.0, 1),  # feet along, nothing of heights
        ({1024: 1, 3072: 2277}, FEET, 1.0, 1),  # the system's number alone
        ({1024: 1, 3072: 2276}, FEET, 1.0, 1),
        ({1024: 1, 3072: 2256}, 0.3048, 1.0, 1),  # Montana's feet are international
        ({1024: 1, 3072: 8706}, 0.3048, 0.3048, 0),  # with heights in feet
        ({1024: 1, 3072: 32632, 3076: 9001, 4099: 9002}, 1.0, 0.3048, 0),
        ({1024: 1, 3072: 32632, 4096: 6360}, 1.0, FEET, 0),  # NAVD88 in feet of the US survey
        ({1024: 1, 3072: 32632, 4096: 5703}, 1.0, 1.0, 0),
        ({1024: 1, 3072: 2277, 3076: 9003, 4096: 5703}, FEET, 1.0, 0),
        ({1024: 1, 3072: 32767, 3076: 9036}, 1000.0, 1.0, 1),
    ],
)
def test_feet_are_honoured(
    keys: dict[int, int], flat: float, high: float, doubts: int, tmp_path: Path
) -> None:
    """Lengths times the unit of the coordinate system, heights times that of theirs; silence is told."""
    path = tiffs.write(tmp_path / "map.tif", heights().astype(np.float32), tags=geo(keys=keys))
    found, said = ground(path)
    assert found == pytest.approx(np.multiply(CORNERS, [high] * 4 + [flat] * 2), rel=1e-6)
    assert [("does not say in which its heights are" in one) for one in said] == [True] * doubts


def test_a_size_of_the_scene_counts(tmp_path: Path) -> None:
    """`size` takes the place of a file's own, in feet, degrees or without any."""
    rows = heights().astype(np.float32)
    for keys in ({1024: 1, 3072: 2277}, {1024: 2, 2048: 4326}, {}):
        path = tiffs.write(tmp_path / "map.tif", rows, tags=geo(keys=keys))
        assert ground(path, size=(7.0, 400.0))[0][4:] == pytest.approx([7.0, 400.0])


@pytest.mark.parametrize(
    "keys", [{1024: 2, 2048: 4326}, {2048: 4326}, {1024: 2, 2048: 4326, 2054: 9102}, {1024: 2}]
)
def test_degrees_are_refused_with_their_size(keys: dict[int, int], tmp_path: Path) -> None:
    """At 46.5 degrees a degree is 76,763 m by 111,161 m (WGS 84): 29 x 19 pixels of 0.001 degrees."""
    tags = geo((0.001, 0.001), keys) | {33922: (DOUBLE, [0.0, 0.0, 0.0, 7.0, 46.51, 0.0])}
    path = tiffs.write(tmp_path / "map.tif", heights().astype(np.float32), tags=tags)
    with pytest.raises(
        SceneError, match=r"measures its pixels in degrees: .* set size = \[2226\.12, 2112\.06\]"
    ):
        ground(path)


@pytest.mark.parametrize(
    "matrix",
    [(10, 0, 0, 10), (10, 0, 0, -10), (-10, 0, 0, -10), (-10, 0, 0, 10), (0, 10, 10, 0), (0, -10, 10, 0)],
)
def test_every_way_round_the_map_faces_north(matrix: Any, tmp_path: Path) -> None:
    """X = a i + b j, Y = d i + e j: what lies in the south-west is there, with and without a size."""
    a, b, d, e = matrix
    i, j = np.meshgrid(np.arange(30), np.arange(20))
    x, y = a * i + b * j, d * i + e * j
    rows = (x - x.min()) * 0.2 + (y - y.min()) * 0.5 + 100.0
    path = tiffs.write(tmp_path / "map.tif", rows.astype(np.float32), tags=geo(matrix=matrix))
    wide, deep = float(np.ptp(x)), float(np.ptp(y))
    corners = [100.0, 100.0 + 0.5 * deep, 100.0 + 0.2 * wide, 100.0 + 0.5 * deep + 0.2 * wide]
    for keys in ({}, {"size": (wide, deep)}):
        assert ground(path, **keys)[0] == pytest.approx([*corners, wide, deep], abs=1e-3)


def test_pixels_of_a_negative_height_are_told(tmp_path: Path) -> None:
    """ModelPixelScale is positive (OGC 19-008r4); GDAL takes the first row for the northernmost anyway."""
    path = tiffs.write(tmp_path / "a.tif", heights().astype(np.float32), tags=geo((10.0, -10.0)))
    found, said = ground(path)
    assert found == pytest.approx(CORNERS, abs=1e-3)
    assert len(said) == 1
    assert "its first row is taken for the northernmost" in said[0]


def test_turned_maps(tmp_path: Path) -> None:
    """30 degrees from the east: refused, or told with a size; with the same rotation in the scene taken."""
    c, s = 10.0 * np.cos(np.pi / 6), 10.0 * np.sin(np.pi / 6)
    rows = heights().astype(np.float32)
    path = tiffs.write(tmp_path / "map.tif", rows, tags=geo(matrix=(c, s, s, -c)))
    with pytest.raises(SceneError, match=r"is turned by 30 degrees .*rotation = \[0, 0, 30\]"):
        ground(path)
    _, said = ground(path, size=(290.0, 190.0))
    assert len(said) == 1
    assert "is turned by 30 degrees" in said[0]
    found, said = ground(path, rotation=(0.0, 0.0, 30.0))
    assert found == pytest.approx(CORNERS, abs=1e-3)
    assert said == []
    skewed = tiffs.write(tmp_path / "b.tif", rows, tags=geo(matrix=(10.0, 3.0, 0.0, -10.0)))
    with pytest.raises(SceneError, match="has pixels that are no rectangles"):
        ground(skewed)


def test_control_points_give_no_size(tmp_path: Path) -> None:
    """Tie points at four corners say where the map lies, but not that its pixels are a grid."""
    ties = [v for k in range(4) for v in (30.0 * (k % 2), 20.0 * (k // 2), 0.0, 5e5 + k, 5e6 + k, 0.0)]
    path = tiffs.write(tmp_path / "map.tif", heights().astype(np.float32), tags={33922: (DOUBLE, ties)})
    with pytest.raises(SceneError, match="is placed by ground control points"):
        ground(path)


def gdal(**roles: str) -> dict[int, tuple[int, Any]]:
    items = "".join(
        f'<Item name="X" sample="0" role="{role}">{value}</Item>' for role, value in roles.items()
    )
    return {42112: (ASCII, f"<GDALMetadata>{items}</GDALMetadata>")}


def test_scale_offset_and_unit_of_the_band(tmp_path: Path) -> None:
    """height = (value scale + offset) unit; the value for missing ones is compared before."""
    rows = ((heights() - 50.0) / 0.1).round().astype(np.int32)
    path = tiffs.write(tmp_path / "map.tif", rows, tags=geo() | gdal(scale="0.1", offset="50"))
    assert ground(path)[0] == pytest.approx(CORNERS, abs=1e-3)
    for word, metres in (("ft", 0.3048), ("metre", 1.0), ("US survey foot", FEET), ("cm", 0.01)):
        path = tiffs.write(
            tmp_path / "map.tif", heights().astype(np.float32), tags=geo() | gdal(unittype=word)
        )
        assert ground(path)[0][:4] == pytest.approx(np.multiply(CORNERS[:4], metres), rel=1e-5)
    for bad, words in ((gdal(unittype="Pa"), 'heights in "Pa"'), (gdal(scale="x"), "no number")):
        with pytest.raises(SceneError, match=words):
            ground(tiffs.write(tmp_path / "map.tif", rows, tags=geo() | bad))
    rows[0, 0] = -9999
    marked = geo() | gdal(scale="0.1", offset="50") | {42113: (ASCII, "-9999")}
    with pytest.raises(SceneError, match="has gaps, 1 in all"):
        ground(tiffs.write(tmp_path / "map.tif", rows, tags=marked))


def test_areas_and_points_have_the_same_size(tmp_path: Path) -> None:
    """Whether a pixel is an area (1) or a point (2): samples lie a pixel apart."""
    for raster in (1, 2):
        keys = {1024: 1, 1025: raster, 3072: 32632}
        path = tiffs.write(tmp_path / "map.tif", heights().astype(np.float32), tags=geo(keys=keys))
        assert ground(path)[0] == pytest.approx(CORNERS, abs=1e-3)


def test_whole_metres_that_make_no_relief_are_warned_of(tmp_path: Path) -> None:
    """int16 metres with a full range of 1 m are 2.3 mm of relief: the height that makes metres is told."""
    rows = heights().astype(np.int16)
    _, said = ground(tiffs.write(tmp_path / "a.tif", rows, tags=geo()))
    assert len(said) == 1
    assert "whole numbers from 100 to 253" in said[0]
    assert "0.00233 m of relief" in said[0]
    assert f"set {NAME}.height = 65535" in said[0]
    path = tiffs.write(tmp_path / "b.tif", rows)
    assert "height = 65535" in ground(path, size=(290.0, 190.0))[1][0]
    full = np.linspace(0, 65535, 600).reshape(20, 30).astype(np.uint16)
    assert ground(tiffs.write(tmp_path / "c.tif", full), size=(4.0, 4.0), height=2.0)[1] == []


def test_what_is_not_read_is_refused_by_name(tmp_path: Path) -> None:
    """Compressions, bands, colours and numbers that no height map has: named, and never "damaged"."""
    rows = heights().astype(np.float32)
    for number, name in {
        34887: "LERC",
        7: "JPEG",
        50001: "WebP",
        50002: "JPEG XL",
        999: "number 999",
    }.items():
        path = tiffs.write(tmp_path / "a.tif", rows, tags=geo() | {259: (SHORT, number)})
        with pytest.raises(SceneError, match=f"is compressed as {name}, which is not read here"):
            ground(path)
    two = np.stack([rows, rows], axis=-1)
    cases = {
        "has 2 bands": (two, geo()),
        "colours .a palette": (rows.astype(np.uint8), {262: (SHORT, 3)}),
        "colours .red, green and blue": (np.stack([rows] * 3, -1).astype(np.uint8), {262: (SHORT, 2)}),
        "numbers of 12 bits": (rows.astype(np.uint16), {258: (SHORT, 12)}),
        "complex numbers": (rows.astype(np.float64), {339: (SHORT, 6)}),
        "bits in reverse order": (rows, {266: (SHORT, 2)}),
        "the predictor 3": (rows.astype(np.uint16), {317: (SHORT, 3)}),
        "geocentric": (rows, geo(keys={1024: 3})),
        "a unit that is not known, EPSG 9999": (rows, geo(keys={1024: 1, 3076: 9999})),
    }
    for words, (numbers, tags) in cases.items():
        with pytest.raises(SceneError, match=words):
            ground(tiffs.write(tmp_path / "a.tif", numbers, tags=tags))


def test_a_strip_that_is_left_out_is_a_gap(tmp_path: Path) -> None:
    """Sparse files leave out what has no value: gaps if the file has a value for those, else zeros."""
    rows = heights().astype(np.float32)
    for tags, words in ((geo() | {42113: (ASCII, "-9999")}, "has gaps, 210 in all"), (geo(), None)):
        path = tiffs.write(tmp_path / "a.tif", rows, tags=tags)
        content = bytearray(Path(path).read_bytes())
        from tifffile import TiffFile

        with TiffFile(path) as file:
            begin = file.pages[0].tags[279].valueoffset
        content[begin : begin + 4] = bytes(4)
        Path(path).write_bytes(content)
        if words:
            with pytest.raises(SceneError, match=words):
                ground(path)
        else:
            assert ground(path)[0][1] == pytest.approx(0.0)


def test_a_cut_file_is_damaged(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Every compression: less than what the tags promise is one sentence, no heights and no other words."""
    for compression in tiffs.PACKINGS:
        path = Path(tiffs.write(tmp_path / "a.tif", heights().astype(np.float32), compression=compression))
        content = path.read_bytes()
        path.write_bytes(content[:8] + bytes(200) + content[208:])
        if compression == 1:  # of which every string of bytes is legal
            continue
        with pytest.raises(SceneError, match="it is damaged"):
            read_tiff(path, "it")
    assert capfd.readouterr() == ("", "")


def test_pictures_are_what_they_are_whatever_they_are_called(tmp_path: Path) -> None:
    """A TIFF named .png and a PNG named .tif are read as what they begin with."""
    path = Path(tiffs.write(tmp_path / "a.png", heights().astype(np.float32), tags=geo()))
    assert ground(str(path))[0] == pytest.approx(CORNERS, abs=1e-3)
    Image.fromarray(heights().astype(np.uint16)).save(tmp_path / "b.png")
    (tmp_path / "b.png").rename(tmp_path / "b.tif")
    found = ground(str(tmp_path / "b.tif"), size=(290.0, 190.0), height=65535.0)[0]
    assert found == pytest.approx(CORNERS, abs=1e-3)
