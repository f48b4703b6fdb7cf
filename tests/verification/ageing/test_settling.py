"""Snow settles as its viscosity says, and grows stronger."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from neve.ageing.days import DAY, Weather, aged
from neve.ageing.settling import load_on, settled, viscosity
from neve.heat import sintering
from neve.snowfall.layers import Layers


def column(thickness=(0.1,) * 5, density=100.0, celsius=-10.0):
    """One place with layers of new snow."""
    k = len(thickness)
    return Layers.fresh(np.array([thickness]), density, celsius, np.zeros(k))


def test_load_is_the_weight_above():
    """Five layers of 10 kg/m2 each: the lowest bears 4.5, the highest half of one."""
    assert load_on(column(), 10.0)[0] == pytest.approx([450.0, 350.0, 250.0, 150.0, 50.0])


def test_viscosity_is_the_published_one():
    """eta0 at 250 kg/m3 and the melting point, but for exp(b rho); 5 % of water make it a quarter."""
    at = viscosity(np.array([250.0]), np.array([0.0]), np.array([0.0]))
    assert at[0] == pytest.approx(7.62237e6 * np.exp(0.023 * 250.0))
    assert viscosity(np.array([250.0]), np.array([-10.0]), np.array([0.0]))[0] == pytest.approx(at[0] * np.e)
    assert viscosity(np.array([250.0]), np.array([0.0]), np.array([0.05]))[0] == pytest.approx(at[0] / 4.0)


def test_column_settles_as_its_equation():
    """d rho / dt = rho sigma / eta by other means to 1e-10, and in any number of steps."""
    start, days = column(), 20.0
    sigma = load_on(start, 9.81)[0]

    def rate(t, rho):
        return rho * sigma / viscosity(rho, np.full(5, -10.0), np.zeros(5))

    wanted = solve_ivp(rate, (0.0, days * DAY), start.density[0], rtol=1e-10, atol=1e-8).y[:, -1]
    once = settled(start, days * DAY, 9.81)
    often = start
    for _ in range(100):
        often = settled(often, days * DAY / 100, 9.81)
    assert once.density[0] == pytest.approx(wanted, rel=1e-8)
    assert often.density[0] == pytest.approx(once.density[0], rel=1e-12)
    assert once.mass[0] == pytest.approx(start.mass[0], rel=1e-14)
    assert np.all(np.diff(once.density[0]) < 0.0)


def test_thin_settling_is_exponential():
    """While the density hardly changes, a layer thins as exp(-sigma t / eta)."""
    start = column((0.1,))
    eta = viscosity(start.density, start.temperature, 0.0 * start.density)[0, 0]
    t = 1e-4 * eta / load_on(start, 9.81)[0, 0]
    thinner = settled(start, t, 9.81).thickness[0, 0] / 0.1
    assert np.log(thinner) == pytest.approx(-1e-4, rel=5e-4)


def test_no_snow_is_denser_than_ice():
    """A load of 100 m of snow for a thousand years ends at 917 kg/m3."""
    assert settled(column((100.0, 100.0), 900.0, 0.0), 3e10, 9.81).density.max() == 917.0


def test_sintering_is_that_of_runs():
    """At -5 deg C strength grows as (t / 1 s)^0.21, in parts as at once, up to ice; cold slows it."""
    one, rho = np.ones((1, 1)), np.full((1, 1), 300.0)
    warm = sintering.grown(one, rho, -5.0 * one, 1e4 - 1.0)
    assert warm[0, 0] == pytest.approx(1e4**0.21)
    parts = sintering.grown(sintering.grown(one, rho, -5.0 * one, 5e3), rho, -5.0 * one, 5e3 - 1.0)
    assert parts[0, 0] == pytest.approx(warm[0, 0])
    assert sintering.grown(one, rho, -20.0 * one, 1e4)[0, 0] < warm[0, 0]
    assert sintering.grown(one, rho, -5.0 * one, 1e12)[0, 0] == pytest.approx((917.0 / 300.0) ** 2.44)


def test_a_week_of_cold():
    """New snow of 50 cm at -5 deg C: a week takes 10 to 60 % of its depth, mass stays, strength grows."""
    now, balance = aged(column((0.1,) * 5, 100.0, -5.0), Weather(air=-5.0), 7.0 * DAY)
    assert 0.4 < now.thickness.sum() / 0.5 < 0.9
    assert balance.mass_after == pytest.approx(balance.mass_before, rel=1e-13)
    assert now.growth.min() > 10.0
    assert np.all(now.age == pytest.approx(7.0 * DAY))
