"""Heat in layers: mass and heat are kept to rounding, melting takes what it must, water freezes again."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from verification.ageing.test_settling import column
from verification.snowfall.surfaces import ground
from verification.snowfall.test_cover import fallen

from neve.ageing.days import DAY, HOUR, Weather, aged, aged_cover
from neve.ageing.warming import enthalpy
from neve.cli.commands import cli
from neve.heat.enthalpy import LATENT
from neve.mpm.initial import build
from neve.run.snowfall import write_cover
from neve.scene.reading.load import scene_from


def random_columns(seed=0):
    """Columns of all sorts: thin and thick layers, empty ones, cold, wet."""
    rng = np.random.default_rng(seed)
    layers = column((0.1,) * 6)
    shape = (50, 6)
    thickness = 10.0 ** rng.uniform(-6, 0, shape) * (rng.random(shape) < 0.8)
    return layers.but(
        thickness=thickness,
        density=rng.uniform(50, 600, shape),
        born=np.full(shape, 50.0),
        temperature=-rng.uniform(0, 20, shape) * (rng.random(shape) < 0.7),
        liquid=np.zeros(shape),
        growth=np.ones(shape),
        age=np.zeros(shape),
    )


@pytest.mark.parametrize("ground", [None, -1.0])
def test_balance_closes_to_rounding(ground):
    """Before + came = after + ran off, for mass and heat, over three days that melt and three cold nights."""
    weather = Weather(air=0.0, swing=8.0, sun=600.0, albedo=0.6, ground=ground)
    now, b = aged(random_columns(), weather, 3.0 * DAY)
    scale = abs(b.heat_before) + abs(b.heat_came) + abs(b.heat_ran_off)
    assert abs(b.mass_before - b.mass_after - b.mass_ran_off) < 1e-11 * b.mass_before
    assert abs(b.heat_before + b.heat_came - b.heat_after - b.heat_ran_off) < 1e-11 * scale
    assert b.mass_ran_off > 0.0
    assert now.temperature.max() <= 0.0
    assert 0.0 <= now.liquid.min() <= now.liquid.max() <= 1.0
    assert now.thickness.min() >= 0.0


def test_melting_takes_its_heat():
    """Ripe snow in still air of 5 deg C melts h T / L a second; what its pores do not hold runs off."""
    start = column((0.1,) * 5, 300.0, 0.0)
    hours = 20.0
    now, b = aged(start, Weather(air=5.0, exchange=20.0), hours * HOUR)
    heat = 20.0 * 5.0 * hours * HOUR
    assert b.heat_came == pytest.approx(heat, rel=1e-12)
    ice = float(np.sum(now.mass * (1.0 - now.liquid)))
    assert b.mass_before - ice == pytest.approx(heat / LATENT, rel=1e-12)
    water = float(np.sum(now.mass * now.liquid))
    pores = float(np.sum(now.thickness - now.mass * (1.0 - now.liquid) / 917.0))
    assert water <= 0.05 * 1000.0 * pores * 1.01
    assert b.mass_ran_off == pytest.approx(heat / LATENT - water, rel=1e-9)


def test_water_freezes_again_in_cold_snow():
    """What melts freezes below, where the snow is cold: it warms, gets denser, and nothing runs off."""
    now, b = aged(column((0.05,) * 8, 200.0, -8.0), Weather(air=3.0, exchange=10.0), 5.0 * HOUR)
    assert b.mass_ran_off == 0.0
    assert now.density.max() > 210.0
    assert now.temperature.min() > -8.0
    later, c = aged(now, Weather(air=-15.0), 3.0 * DAY)
    assert later.liquid.max() == 0.0
    assert c.mass_after == pytest.approx(b.mass_before, rel=1e-12)


def test_all_melts():
    """Summer leaves no snow, and the water has the heat of melting it, and of warming before it left."""
    start = random_columns(1)
    start = start.but(thickness=0.1 * start.thickness)
    now, b = aged(start, Weather(air=25.0, exchange=25.0), 3.0 * DAY)
    assert not now.mass.any()
    assert b.mass_ran_off == pytest.approx(b.mass_before, rel=1e-12)
    assert b.heat_ran_off >= LATENT * b.mass_before * (1.0 - 1e-12)
    assert enthalpy(now).sum() == 0.0


def test_cold_goes_in_as_the_equation_says():
    """A step of the surface by 10 K goes into deep snow as 10 erfc(z / (2 sqrt(kappa t))), to 0.25 K.

    Layers of 1 cm, steps of 600 s: the error of both is some 2 % of the step.
    """
    k, rho, t = 100, 300.0, 12.0 * HOUR
    start = column((0.01,) * k, rho, 0.0).but(temperature=np.full((1, k), -5.0))
    now, _ = aged(start, Weather(air=-15.0, exchange=1e4), t, gravity=0.0)
    kappa = (2.5e-6 * rho**2 - 1.23e-4 * rho + 0.024) / (rho * 2100.0)
    z = 0.01 * (k - np.arange(k) - 0.5)
    wanted = [-5.0 - 10.0 * math.erfc(depth / (2.0 * math.sqrt(kappa * t))) for depth in z]
    assert np.abs(now.temperature[0] - wanted).max() < 0.25


def test_command_ages_a_folder_and_a_scene_reads_it(tmp_path):
    """`neve age` on a result of `neve snow`: settled snow that a run takes, denser, stiffer and stronger."""
    cover = fallen([ground()], depth=0.4, size=(2.0, 2.0), density=100.0)
    write_cover(cover, tmp_path / "new")
    words = f"age {tmp_path}/new --days 3 --air -4 --out {tmp_path}/old --quiet".split()
    assert CliRunner().invoke(cli, words).exit_code == 0
    books = json.loads((tmp_path / "old/books.json").read_text())
    assert books["mass_before"] == pytest.approx(books["mass_after"], rel=1e-12)
    assert len((tmp_path / "old/layers.csv").read_text().splitlines()) == 5
    old, balance = aged_cover(cover, Weather(air=-4.0), 3.0 * DAY)
    assert balance.mass_after == pytest.approx(cover.mass)
    data = {
        "numerics": {"dx": 0.1},
        "snow": {"law": "cam_clay", "rho0": 100.0, "p0": 100.0},
        "sources": [{"shape": "lying", "file": str(tmp_path / "old/cover.npz")}],
        "colliders": [{"shape": "plane"}],
    }
    _, state, _ = build(scene_from(data))
    assert float(state.m.sum()) == pytest.approx(40.0 * 4.0, rel=1e-5)
    assert float(np.asarray(state.x)[:, 2].max()) < old.depth.max() < 0.39
    assert np.asarray(state.stiffness).min() > 1.05
    assert np.asarray(state.strength).min() > 5.0


def test_command_ages_a_level_layer(tmp_path):
    """A scene with a layer of snow: its profile is written, lower layers the denser."""
    scene = tmp_path / "layer.toml"
    scene.write_text('[snow]\nrho0 = 150.0\n[[sources]]\nshape = "layer"\ndepth = 0.4\n')
    words = ["age", str(scene), "--days", "2", "--out", str(tmp_path / "old"), "--quiet"]
    assert CliRunner().invoke(cli, words).exit_code == 0
    rows = np.genfromtxt(tmp_path / "old/layers.csv", delimiter=",", names=True)
    assert len(rows) == 8
    assert np.all(np.diff(rows["density"]) < 0.0)
    assert rows["top"][-1] < 0.4
