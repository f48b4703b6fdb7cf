"""Esri ASCII grids and SRTM tiles: heights, sizes, gaps, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tiffs
from test_geotiff import CORNERS, FEET, ground

from neve.geometry.maps.ascii_grid import PART
from neve.geometry.maps.ascii_grid import read_ascii_grid as read
from neve.geometry.maps.hgt import read_hgt
from neve.io.assets import companions
from neve.scene.errors import SceneError

HEAD = "ncols 30\nnrows 20\nxllcorner 500000\nyllcorner 5200000\ncellsize 10\nNODATA_value -9999\n"


def rows(ending: str = "\n", form: str = "{:g}") -> str:
    return ending.join(" ".join(form.format(z) for z in row) for row in tiffs.heights()) + ending


@pytest.mark.parametrize(
    ("head", "body"),
    [
        (HEAD, rows()),
        (HEAD.replace("corner", "center").upper(), rows(form="{:.6E}")),
        (HEAD.replace("\n", "\r\n"), rows("\r\n")),
        (HEAD.replace("\n", "\r"), rows("\r")),
        (HEAD.replace(" ", "\t   "), "   " + rows().replace(" ", "\t")),
        ("\ufeff" + HEAD, rows()),
        (HEAD.replace("cellsize 10", "dx 10\ndy 10.0"), rows()),
        ("nrows 20\ncellsize 1e1\nncols 30\n", rows()),
        (HEAD, "\n".join(rows().split()) + "\n"),  # a number a line
        (HEAD, " ".join(rows().split())),  # all in one, no end of line
    ],
)
def test_grids_of_text(head: str, body: str, tmp_path: Path) -> None:
    """Rows from north to south, wrapped anyhow: 100 m in the south-west, 253 m in the north-east."""
    path = tmp_path / "map.asc"
    path.write_bytes((head + body).encode())
    found, said = ground(str(path))
    assert found == pytest.approx(CORNERS, abs=1e-3)
    assert said == []


def test_cells_that_are_no_squares(tmp_path: Path) -> None:
    """dx and dy are each counted; whole numbers are metres, and `height` is a factor."""
    path = tmp_path / "map.asc"
    path.write_text(HEAD.replace("cellsize 10", "dx 10\ndy 5") + rows())
    assert ground(str(path), height=2.0)[0] == pytest.approx([200, 390, 316, 506, 290, 95], abs=1e-3)


def test_numbers_at_the_seams_of_parts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Text is read part by part; a number that a part would cut stays whole."""
    path = tmp_path / "map.asc"
    path.write_text(HEAD + rows(form="{:.9f}"))
    whole = read(path, "it").values
    assert path.stat().st_size < PART
    for part in (1, 7, 100):
        monkeypatch.setattr("neve.geometry.maps.ascii_grid.PART", part)
        assert np.array_equal(read(path, "it").values, whole)


@pytest.mark.parametrize(
    ("word", "missing"), [("-9999", "-9999"), ("-9999.0", "-9999"), ("nan", "nan"), ("-1e38", "-1e38")]
)
def test_gaps_of_grids(word: str, missing: str, tmp_path: Path) -> None:
    """The value for missing heights, however it is written; -9999 if the header has none."""
    path = tmp_path / "map.asc"
    heads = [HEAD.replace("-9999", missing)] + (
        [HEAD.replace("NODATA_value -9999\n", "")] if "9999" in word else []
    )
    for head in heads:
        path.write_text(head + rows().replace("195 ", f"{word} ", 1))
        with pytest.raises(SceneError, match="has gaps, 1 in all"):
            ground(str(path))


PRJ = {
    'PROJCS["T",GEOGCS["N",UNIT["Degree",0.0174532925]],UNIT["Foot_US",0.3048006096012192]]': (FEET, 1.0, 1),
    'PROJCS["T",GEOGCS["N",UNIT["Degree",0.0174532925]],UNIT["Meter",1.0]],VERTCS["V",UNIT["Foot",0.3048]]': (
        1.0,
        0.3048,
        0,
    ),
    "Projection    UTM\nZone 11\nZunits        METERS\nUnits         METERS\nParameters\n": (1.0, 1.0, 0),
    "Projection    STATEPLANE\nUnits         FEET\nZunits FEET\n": (FEET, FEET, 0),
}


@pytest.mark.parametrize("text", PRJ)
def test_units_beside_a_grid(text: str, tmp_path: Path) -> None:
    """The .prj file says in what lengths and heights are; it is kept with a run."""
    flat, high, doubts = PRJ[text]
    path = tmp_path / "map.asc"
    path.write_text(HEAD + rows())
    path.with_suffix(".prj").write_text(text)
    found, said = ground(str(path))
    assert found == pytest.approx(np.multiply(CORNERS, [high] * 4 + [flat] * 2), rel=1e-5)
    assert len(said) == doubts
    assert companions(path) == [path.with_suffix(".prj")]


def test_degrees_of_grids(tmp_path: Path) -> None:
    """Said by the .prj file: refused with the size; seen in relief that no ground has: warned of."""
    path = tmp_path / "map.asc"
    path.write_text(HEAD.replace("cellsize 10", "cellsize 0.001").replace("5200000", "46.49") + rows())
    assert "if its pixels are degrees" in ground(str(path))[1][0]
    path.with_suffix(".prj").write_text('GEOGCS["G",UNIT["Degree",0.0174532925199433]]')
    with pytest.raises(
        SceneError, match=r"its latitude of 46.5 degrees .* set size = \[2226\.12, 2112\.06\]"
    ):
        ground(str(path))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD + rows()[:-5], "has fewer numbers than its header says, 30 x 20"),
        (HEAD + rows() + "5 5\n", "has more numbers than its header says, 30 x 20"),
        (HEAD + rows().replace("197", "1o7", 1), 'has "1o7" among its numbers'),
        (HEAD + rows(form="{:g},5"), "among its numbers: numbers have points, not commas"),
        (HEAD.replace("10", "0,5") + rows(), 'its cellsize is "0,5": numbers have points, not commas'),
        (HEAD.replace("cellsize 10\n", "") + rows(), "has no length as cellsize, or as dx and dy"),
        (HEAD.replace("cellsize 10", "cellsize -1") + rows(), "has no length as cellsize"),
        (HEAD.replace("ncols 30\n", "") + rows(), "no whole number as ncols"),
        (HEAD.replace("30", "30.5") + rows(), "no whole number as ncols"),
        (HEAD.replace("30", "3000000000") + rows(), "use a smaller map"),
        (HEAD.replace("30", "30000") + rows(), "has fewer numbers than its header says"),
        ("north: 5\nsouth: 1\n", "is an ASCII grid of GRASS"),
        ("DSAA\n30 20\n", "is a grid of Surfer"),
        ("Dear snow, fall well.\n", 'its header has "Dear snow, fall well."'),
        ("", "no whole number as ncols"),
        ("\0" * 5000, "is no Esri ASCII grid"),
    ],
)
def test_bad_grids_are_one_sentence(text: str, words: str, tmp_path: Path) -> None:
    """What is cut, of another kind or has no number where one must be: named."""
    path = tmp_path / "map.asc"
    path.write_text(text)
    with pytest.raises(SceneError) as caught:
        ground(str(path))
    assert words in str(caught.value)
    assert str(caught.value).startswith(f'colliders.0.file = "{path}" ')


def tile(path: Path, side: int = 1201) -> np.ndarray:
    """Write a tile of 1000 + i + 2 j metres, i to the east and j to the north; return its rows."""
    i, j = np.meshgrid(np.arange(side), np.arange(side))
    made = (1000 + i % 500 + 2 * (j % 300))[::-1].astype(">i2")
    made.tofile(path)
    return made


def test_tiles_of_the_shuttle(tmp_path: Path) -> None:
    """A degree at 46.5 degrees is 76,763 m by 111,161 m (WGS 84), north and south, of 3 or 1 arc seconds."""
    np.zeros((3601, 3601), np.int16).tofile(tmp_path / "S47W123.hgt")
    assert read_hgt(tmp_path / "S47W123.hgt", "it").pixel == pytest.approx((76762.6 / 3600, 111161.1 / 3600))
    rows = tile(tmp_path / "n46e007-0a1b2c3d4e5f.HGT")
    found, said = ground(str(tmp_path / "n46e007-0a1b2c3d4e5f.HGT"))
    corners = [rows[-1, 0], rows[0, 0], rows[-1, -1], rows[0, -1]]
    assert found == pytest.approx([*corners, 76762.6, 111161.1], rel=1e-5)
    assert said == []


def test_bad_tiles_are_one_sentence(tmp_path: Path) -> None:
    """Voids are gaps; a name without a place, and another length, are told."""
    path = tmp_path / "N46E007.hgt"
    rows = tile(path)
    rows[600, 600:603] = -32768
    rows.tofile(path)
    with pytest.raises(SceneError, match="has gaps, 3 in all"):
        ground(str(path))
    tile(tmp_path / "alps.hgt")
    with pytest.raises(SceneError, match=r"has a name that says no place, as N46E007\.hgt does"):
        ground(str(tmp_path / "alps.hgt"))
    assert ground(str(tmp_path / "alps.hgt"), size=(1e4, 2e4))[0][4:] == pytest.approx([1e4, 2e4])
    path.write_bytes(b"\0" * 1000)
    with pytest.raises(SceneError, match=r"has 1,000 bytes: an \.hgt file has 1201 x 1201"):
        ground(str(path))
