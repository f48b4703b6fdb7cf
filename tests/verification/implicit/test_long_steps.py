"""Long steps, of the oedometer to 50 times the explicit ones: it and a heap end where those leave them."""

from functools import cache

import numpy as np
import pytest

from neve.validate.grains.repose import repose
from neve.validate.snow.oedometer import answer, compress


@pytest.mark.parametrize("integrator", ["semi_implicit", "implicit"])
@pytest.mark.parametrize("times", [1, 10, 50])
def test_an_oedometer(integrator, times):
    """Known answer 13 to nine tenths of the height: the axial stress within 3 %, as of the case itself.

    Snow that hardens by half; no step is refused. An explicit step is 0.5 ms in the end.
    """
    dt = times * 5e-4
    r = compress(8, last=0.9, rate=0.5, points=4, integrator=integrator, dt=dt, implicit_strain=1.0)
    assert r.steps == round(0.2 / dt)
    np.testing.assert_allclose(r.axial, answer(r.s)[0], rtol=0.03)


@cache
def slope(integrator, dt, dt_max=None, strain=None):
    """Mean of two heaps of known answer 23, 6 cells high [degrees]: lone grains change one by half of one."""
    how = {key: value for key, value in (("dt_max", dt_max), ("implicit_strain", strain)) if value}
    runs = [repose(20.0, 6, 0.5, integrator=integrator, dt=dt, seed=seed, **how) for seed in (0, 1)]
    return float(np.mean([run.angle for run in runs]))


@pytest.mark.parametrize(
    "how",
    [
        pytest.param({"dt": 7e-4, "strain": 1.0}, id="0.7 ms"),
        pytest.param({"dt": 7e-3, "strain": 1.0}, id="7 ms"),
        pytest.param({"dt": "auto", "dt_max": 35e-3}, id="auto up to 35 ms"),
    ],
)
def test_a_heap(how):
    """The slope of explicit steps, of 0.56 ms, within 5 %.

    In 35 ms a grain that falls would cross a cell and a half: the automatic choice takes shorter steps then,
    1.4 ms in the mean.
    """
    assert slope("implicit", **how) == pytest.approx(slope("explicit", "auto"), rel=0.05)


def test_a_heap_of_stiff_grains():
    """Grains of 1e7 Pa, steps of 0.7 ms, twelve times the explicit ones: the same slope within 5 %.

    With polypic, whose slope does not depend on the step; with apic explicit steps of 0.06 ms leave 12 % more
    than explicit steps of 0.56 ms do, of grains soft enough for both.
    """
    snow = {"law": "drucker_prager", "rho0": 400.0, "E0": 1e7, "nu": 0.3, "friction_angle": 20.0}
    angles = [
        np.mean(
            [repose(20.0, 6, 0.5, snow=snow, transfer="polypic", seed=seed, **how).angle for seed in (0, 1)]
        )
        for how in (
            {"integrator": "explicit", "dt": 6e-5},
            {"integrator": "implicit", "dt": 7e-4, "implicit_strain": 1.0},
        )
    ]
    assert angles[1] == pytest.approx(angles[0], rel=0.05)
