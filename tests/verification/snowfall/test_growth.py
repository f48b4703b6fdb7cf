"""How snow grew: its particles fill what lies at each moment, and what slid away is gone again."""

import numpy as np
import pytest
from verification.snowfall.surfaces import ground

from neve.scene.schema.snowfall import Snowfall
from neve.snowfall.cover import Raster, let_fall
from neve.snowfall.growth import Growth
from neve.snowfall.surroundings import joined

SPACING = 0.05


@pytest.fixture(scope="module")
def cover():
    """20 cm on level ground."""
    fall = Snowfall(size=(2.0, 2.0), depth=0.2, flutter=0.0, steps=1)
    return let_fall(fall, joined([ground()]), Raster.over((0.0, 0.0), (2.0, 2.0), SPACING))


def grown(cover, *depths):
    """Its growth through these depths [m]."""
    return Growth.of(cover, np.outer(depths, np.ones(len(cover.z))), SPACING, 0)


@pytest.mark.parametrize(
    ("share", "depth"), [(0.0, 0.0), (0.25, 0.04), (0.5, 0.08), (0.75, 0.14), (1.0, 0.2)]
)
def test_particles_have_the_volume_of_the_snow(cover, share, depth):
    """The depth is even between parts; of a layer that is half there each particle is with even chance.

    So four deviations of sqrt(N p (1 - p)) particles, N those of a layer, p how much of it is there.
    """
    growth = grown(cover, 0.0, 0.08, 0.2)
    layer = len(cover.z)
    part = depth / SPACING % 1.0
    count = len(growth.at(share))
    assert abs(count - layer * depth / SPACING) <= 4.0 * np.sqrt(layer * part * (1.0 - part)) + 1e-6 * layer


def test_what_lies_stays_until_it_slides(cover):
    """While the snow grows every particle stays; where it gets thinner the highest go."""
    growth = grown(cover, 0.0, 0.3, 0.1)
    first, deep, last = (set(growth.at(share).tolist()) for share in (0.25, 0.5, 1.0))
    assert first < deep
    assert last < deep
    assert growth.height[list(last)].max() < 0.1 < growth.height[list(deep - last)].min()
    assert growth.x[list(last), 2].max() < 0.1 + SPACING
    assert growth.x[:, 2].min() > 0.0


def test_a_fall_shows_its_parts():
    """`seen` hears of no snow, then of each part; the last is what lies."""
    depths = []
    fall = Snowfall(size=(1.0, 1.0), depth=0.2, flutter=0.0, steps=3)
    raster = Raster.over((0.0, 0.0), (1.0, 1.0), 0.1)
    cover = let_fall(fall, joined([ground()]), raster, seen=depths.append)
    assert [float(d.mean()) for d in depths] == pytest.approx([0.0, 0.2 / 3, 0.4 / 3, 0.2])
    assert np.array_equal(depths[-1], cover.depth)
