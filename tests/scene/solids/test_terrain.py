"""Height maps: every format, which way round they lie, how high they are, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, TiffImagePlugin

from neve.geometry.maps.geotiff import GEO_KEYS, PIXEL_SCALE
from neve.geometry.maps.tiff import NO_DATA
from neve.geometry.terrain import height_field
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Collider

NAME = "colliders.0"
HEIGHTS = np.array([[0.0, 10.0, 20.0, 30.0], [40.0, 50.0, 60.0, 70.0], [80.0, 90.0, 100.0, 110.0]])
"""heights[x, y]: 3 along x, 4 along y."""


def picture(heights: Any, path: Path, kind: Any, tags: dict[int, tuple[int, Any]] | None = None) -> str:
    """Save heights[x, y] as a picture seen from above, with tags {number: (type, value)} if it is a TIFF."""
    image = Image.fromarray(np.ascontiguousarray(np.asarray(heights).T[::-1]).astype(kind))
    if tags is None:
        image.save(path)
    else:
        info = TiffImagePlugin.ImageFileDirectory_v2()
        for number, (kind_of_tag, value) in tags.items():
            info.tagtype[number] = kind_of_tag
            info[number] = value
        image.save(path, tiffinfo=info)
    return str(path)


def ground_at(field: Any, size: tuple[float, float]) -> Any:
    """Return the heights of the 3 x 4 samples, found by their distance below a point above each."""
    x = np.linspace(-0.5 * size[0], 0.5 * size[0], 3)
    y = np.linspace(-0.5 * size[1], 0.5 * size[1], 4)
    points = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((3, 4))], axis=-1).reshape(-1, 3)
    phi, normal = field.sample(points)
    return (-np.asarray(phi) / np.asarray(normal)[:, 2]).reshape(3, 4)


@pytest.mark.parametrize(
    ("name", "kind", "height"),
    [
        ("a.png", np.uint8, 255.0),
        ("a.png", np.uint16, 65535.0),
        ("a.tif", np.uint16, 65535.0),
        ("a.tiff", np.float32, 1.0),
        ("a.npy", np.float64, 1.0),
        ("a.npy", np.int64, 1.0),
        ("a.npy", np.uint8, 255.0),
        ("a.npy", np.int16, 65535.0),
    ],
)
def test_every_format_lies_the_same_way(name: str, kind: Any, height: float, tmp_path: Path) -> None:
    """x to the right and y upward in a picture, heights[x, y] in an array; the numbers are metres as told.

    phi = (z - h) n_z at the samples, so that h = -phi / n_z at z = 0; heights are single precision.
    """
    path = tmp_path / name
    if path.suffix == ".npy":
        np.save(path, HEIGHTS.astype(kind))
    else:
        picture(HEIGHTS, path, kind)
    field = height_field(Collider.of("terrain", file=str(path), size=(4.0, 6.0), height=height), NAME)
    assert ground_at(field, (4.0, 6.0)) == pytest.approx(HEIGHTS, rel=1e-5, abs=1e-4)
    half = height_field(Collider.of("terrain", file=str(path), size=(4.0, 6.0), height=0.5 * height), NAME)
    assert ground_at(half, (4.0, 6.0)) == pytest.approx(0.5 * HEIGHTS, rel=1e-5, abs=1e-4)


def test_size_of_a_geotiff(tmp_path: Path) -> None:
    """Pixels of 2 x 3 m: three samples along x are 4 m apart, four along y 9 m; `size` overrides that."""
    scale = {PIXEL_SCALE: (12, (2.0, 3.0, 0.0))}
    path = picture(HEIGHTS, tmp_path / "a.tif", np.float32, scale)
    assert height_field(Collider.of("terrain", file=path), NAME).size == (4.0, 9.0)
    assert height_field(Collider.of("terrain", file=path, size=(1.0, 1.0)), NAME).size == (1.0, 1.0)
    degrees = scale | {GEO_KEYS: (3, (1, 1, 0, 1, 1024, 0, 1, 2))}
    path = picture(HEIGHTS, tmp_path / "b.tif", np.float32, degrees)
    with pytest.raises(
        SceneError, match=r"^colliders\.0\.size is missing, and .* measures its pixels in degrees: at its "
    ):
        height_field(Collider.of("terrain", file=path), NAME)


def test_bad_maps_are_one_sentence(tmp_path: Path) -> None:
    """What cannot be ground: one sentence with the file, and what a map is."""
    holed = HEIGHTS.copy()
    holed[1, 2] = np.nan
    marked = np.where(np.isnan(holed), -9999.0, holed)
    np.save(tmp_path / "nan.npy", holed)
    np.save(tmp_path / "line.npy", HEIGHTS[0])
    np.save(tmp_path / "thin.npy", HEIGHTS[:1])
    np.save(tmp_path / "cube.npy", np.zeros((2, 2, 2)))
    np.save(tmp_path / "words.npy", np.array([["a", "b"], ["c", "d"]]))
    np.save(tmp_path / "far.npy", 1e9 * HEIGHTS)
    picture(marked, tmp_path / "gap.tif", np.float32, {NO_DATA: (2, "-9999")})
    Image.new("RGB", (4, 4)).save(tmp_path / "color.png")
    Image.new("P", (4, 4)).save(tmp_path / "palette.png")
    for name in ("letter.png", "letter.tif", "letter.npy"):
        (tmp_path / name).write_text("Dear snow,\nfall well.\n")
    (tmp_path / "empty.npy").touch()
    whole = picture(HEIGHTS, tmp_path / "cut.png", np.uint16)
    Path(whole).write_bytes(Path(whole).read_bytes()[:60])
    for name, words in {
        "nan.npy": "has gaps, 1 in all, where the height is no finite number",
        "gap.tif": "has gaps, 1 in all, where the height is no finite number",
        "line.npy": "has 1 axes: a height map has two axes",
        "thin.npy": "has 1 x 4 numbers: a height map has two axes, x and y, each of 2 numbers or more",
        "cube.npy": "has 3 axes",
        "words.npy": "holds no numbers",
        "far.npy": "reaches beyond 1e6 m",
        "color.png": "is a picture in colours",
        "palette.png": "is a picture in colours",
        "letter.png": "cannot be read: it is damaged",
        "letter.tif": "cannot be read: it is damaged",
        "letter.npy": "cannot be read: it is damaged",
        "empty.npy": "cannot be read: it is damaged",
        "cut.png": "cannot be read",
    }.items():
        with pytest.raises(SceneError) as caught:
            height_field(Collider.of("terrain", file=str(tmp_path / name), size=(1.0, 1.0)), NAME)
        text = str(caught.value)
        assert text.startswith(f'colliders.0.file = "{tmp_path / name}" '), name
        assert words in text, name
        assert text.count(".") >= 1
        assert text.endswith(".")


def test_large_maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A map of more samples than are allowed is told before it is unpacked, a picture as an array."""
    monkeypatch.setattr("neve.geometry.maps.found.MAX_SAMPLES", 10)
    np.save(tmp_path / "a.npy", HEIGHTS)
    picture(HEIGHTS, tmp_path / "a.png", np.uint8)
    for name, words in {"a.npy": "12 heights, more than 10", "a.png": "12 pixels, more than 10"}.items():
        with pytest.raises(SceneError, match=words):
            height_field(Collider.of("terrain", file=str(tmp_path / name), size=(1.0, 1.0)), NAME)


def test_names_of_maps() -> None:
    """A map that is missing, or of another kind, is told when the scene is read."""
    for keys, words in (
        ({}, "must name a height map"),
        ({"file": "no.png"}, 'no.png" is not a file; name a .png, .tif, .tiff, .asc, .hgt or .npy file'),
        ({"file": "no.jpg"}, 'must end in ".png", ".tif", ".tiff", ".asc", ".hgt" or ".npy"'),
        ({"file": "neve:no"}, '"neve:no" does not come with Neve'),
    ):
        with pytest.raises(SceneError) as caught:
            scene_from({"sources": [{"shape": "box"}], "colliders": [{"shape": "terrain", **keys}]})
        assert words in str(caught.value)
