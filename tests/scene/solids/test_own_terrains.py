"""The height maps that come with Neve: small, made by the script, level where ground goes on beyond them."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scripts import script

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "src/neve" / "assets" / "terrains"
NAMES = sorted(path.stem for path in FOLDER.glob("*.png"))


@pytest.fixture(scope="module")
def maker():
    """The script, imported from its folder."""
    with script("tools/terrains", "make_terrains") as module:
        yield module


def test_all_are_here(maker):
    """The script's list and the folder name the same maps."""
    assert sorted(maker.TERRAINS) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_small_and_made_by_the_script(maker, name):
    """Below 300 kB, of 16 bits, and what the script makes, to one unit, as sines may differ."""
    path = FOLDER / f"{name}.png"
    assert path.stat().st_size < 300_000
    values = np.asarray(Image.open(path), np.int64)
    assert values.max() > 255
    assert np.abs(values - maker.make(name).astype(np.int64)).max() <= 1


@pytest.mark.parametrize("name", ["hollow", "lane"])
def test_ground_around_hollows_is_level(maker, name):
    """The edge has one height, to one unit, so that the ground beyond it is a plane; in the middle the ground
    is lower by half of the full range."""
    values = maker.make(name).astype(np.int64)
    edge = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    assert np.ptp(edge) <= 1
    assert values[values.shape[0] // 2, values.shape[1] // 2] < edge[0] - 32768


def test_slope_falls_to_the_right(maker):
    """Along the middle of the gully the ground falls by 7 m of 10 or more; no step rises by over 2 cm."""
    heights = maker.slope()[:, 100] * 10.0
    assert heights[0] - heights[-1] > 7.0
    assert np.diff(heights).max() < 0.02
