"""Wind moves snow that lies: mass is kept, open fields stay, walls get a drift in their lee."""

import numpy as np
import pytest
from verification.snowfall.surfaces import box, ground
from verification.snowfall.test_cover import fallen

from neve.scene.errors import SceneWarning
from neve.snowfall import cover
from neve.snowfall.drift import LEE, THRESHOLD, Field, carried, drifted, friction_velocity

WALL = [ground(), box((-0.1, -50.0, 0.0), (0.1, 50.0, 1.0))]


def blown(pieces=WALL, hours=3.0, wind=(12.0, 0.0), size=(40.0, 2.0), cell=0.2, **keys):
    """A fall of 30 cm in still air, then wind."""
    own = {"depth": 0.3, "flutter": 0.0, "density": 100.0, "steps": 1, "repose": 40.0, **keys}
    return fallen(pieces, cell=cell, size=size, drift=hours, drift_wind=wind, **own)


def along(cover):
    """x and the height of the snow's top, in order of x, of the middle row on the ground."""
    x = cover.x
    row = (np.abs(x[:, 1]) < 0.15) & (cover.z < 0.5)
    order = np.argsort(x[row, 0])
    return x[row, 0][order], cover.depth[row][order]


def test_flux_is_the_published_one():
    """0.68 rho u_t (u^2 - u_t^2) / (g u): nothing at the threshold, which is a wind of 6.8 m/s at 10 m."""
    assert carried(np.array([THRESHOLD, 0.1])).tolist() == [0.0, 0.0]
    assert carried(np.array([0.5]))[0] == pytest.approx(0.68 * 1.3 * 0.25 * (0.25 - 0.0625) / (9.81 * 0.5))
    assert friction_velocity((6.8, 0.0)) == pytest.approx(THRESHOLD, rel=0.01)


@pytest.mark.parametrize("wind", [(12.0, 0.0), (-9.0, 7.0), (0.0, -11.0), (6.0, -9.0)])
def test_mass_is_kept(wind):
    """What lies, with what the wind took out and brought, is what fell, to rounding; from any side."""
    house = [ground(), box((-1.0, -0.5, 0.0), (1.0, 0.5, 1.2))]
    b = blown(house, hours=1.0, wind=wind, size=(12.0, 12.0)).books
    assert b.fell == pytest.approx(b.lies + b.missed + b.slid + b.blown, abs=1e-12 * b.fell * 100)
    assert b.blown != 0.0


def test_wind_that_is_not_counted_to_its_end_is_told(monkeypatch):
    """After the most steps the hours that are left are in the books, and a warning says so."""
    assert blown(hours=1.0).books.calm == 0.0
    monkeypatch.setattr(cover, "MOST_STEPS", 3)
    with pytest.warns(SceneWarning, match=r"the wind blew for \S+ of 1 h: use a larger cell"):
        books = blown(hours=1.0).books
    assert 0.0 < books.calm < 1.0
    assert books.fell == pytest.approx(books.lies + books.missed + books.slid + books.blown, abs=1e-10)


def test_what_the_wind_piled_up_and_still_slides_is_told(monkeypatch):
    """Snow that falls level and slides only once it has drifted: that too."""
    monkeypatch.setattr(cover, "MOST_PASSES", 0)
    with pytest.warns(SceneWarning, match="some snow still slides"):
        assert not blown(hours=1.0).books.settled


def test_an_open_field_stays_as_it_is():
    """Where the wind is the same everywhere it brings what it takes: the depth stays, to rounding."""
    cover = blown([ground()])
    assert np.abs(cover.depth - 0.3).max() < 1e-12
    assert abs(cover.books.blown) < 1e-9


def test_weak_wind_moves_nothing():
    """Below the threshold no snow moves."""
    assert np.array_equal(blown(wind=(6.0, 0.0)).depth, blown(hours=0.0).depth)


def test_drift_lies_in_the_lee():
    """Behind a wall of 1 m: deepest at the wall, above the field for no more than ten heights.

    Before the wall less comes to lie, within three heights, as the wind is slowed there; farther upwind the
    field is what it was. Behind the drift the wind picks up snow again.
    """
    x, depth = along(blown())
    lee, front = x > 0.1, x < -0.1
    more = np.maximum(depth - 0.3, 0.0)
    assert x[lee][depth[lee].argmax()] < 1.0
    assert depth[lee].max() > 0.45
    assert x[lee][more[lee] > 0.01].max() < 10.0
    assert more[lee].sum() > 2.0 * more[front].sum()
    assert np.abs(depth[x < -3.0] - 0.3).max() < 0.01
    assert 0.15 < depth[x > 5.0].min() < 0.27


def test_a_full_drift_is_as_high_as_its_wall():
    """Once it is full the drift grows longer, not higher, and ends in a slope of repose."""
    x, depth = along(blown(hours=20.0, size=(24.0, 0.6)))
    lee = (x > 0.3) & (x < 4.0)
    assert np.abs(depth[lee] - 1.0).max() < 0.02
    assert depth.max() < 1.02
    steepest = np.abs(np.diff(np.unique(depth[x > 4.0]))).max() / 0.2
    assert steepest < np.tan(np.radians(40.0)) + 0.01


def test_shelter_is_the_slope_to_the_horizon():
    """A step of 1 m, 5 m upwind: 1 - 0.2 / 0.3 of the wind."""
    top = np.zeros((60, 3))
    top[10] = 1.0
    slowed = Field.of(0.5, (8.0, 0.0)).slowed(top)
    assert slowed[20, 1] == pytest.approx(1.0 - (1.0 / 5.0) / LEE)
    assert slowed[12, 1] == 0.0
    assert slowed[59, 1] > 0.8


def test_no_place_keeps_what_flies_over_a_void():
    """Over cells without any surface the snow flies on."""
    top = np.full((40, 4), -np.inf)
    top[:10] = top[20:] = 0.0
    depth = np.where(np.isfinite(top), 0.2, 0.0)
    new, _, came, went = drifted(top, depth, 100.0, 0.5, (10.0, 0.0), 600.0)
    assert not new[10:20].any()
    assert (new.sum() - depth.sum()) * 0.25 == pytest.approx(came - went, abs=1e-12)
