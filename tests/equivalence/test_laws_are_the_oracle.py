"""Whole steps with each law, and with all laws mixed in every lane pack, are the oracle's."""

from dataclasses import replace

import numpy as np
import pytest
from reference import step
from reference.laws import LAWS
from reference.snow import ELASTICITIES, Snow
from reference.splines import NODES
from verification.stages import Lab

from neve import _core
from neve.scene.values import choices

DX, DT, GRAVITY = 0.05, 2e-4, (0.3, -0.2, -9.81)
NAMES = ("x", "v", "C", "F_E", "J_P", "m", "V0")
SCALES = {"x": 0.2, "v": 3.0, "F_E": 1.0, "J_P": 1.0}
SOFT = {  # so that this DT resolves the waves
    name: replace(snow, E0=2e5, p0=snow.p0 * 2e5 / snow.E0) for name, snow in LAWS.items()
}
ORDERS = [("quadratic", "apic"), ("cubic", "flip")]


def test_every_choice_has_its_equations_in_numpy():
    """A law or spline of the core is one of the oracle too: other tests would pass it over."""
    assert set(ELASTICITIES) == set(choices.LAWS)
    assert {snow.law for snow in LAWS.values()} == set(choices.LAWS)
    assert set(NODES) == set(choices.SPLINES)


def cloud(rows, n=500, seed=9):
    """Spinning particles with strains on both sides of the yield limits; every material in every pack."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-0.13, 0.13, (n, 3))
    alone = np.array([row.plasticity == "none" for row in rows])
    material = rng.integers(0, len(rows), n)
    J_P = rng.uniform(0.97, 1.03, n)
    return {
        "x": x,
        "v": np.cross([4.0, -3.0, 6.0], x) + 0.3 * rng.standard_normal((n, 3)) + [0.5, 0, -1],
        "C": 4 * rng.standard_normal((n, 3, 3)),
        "F_E": np.eye(3) + 0.006 * rng.standard_normal((n, 3, 3)),
        "J_P": np.where(alone[material], 1.0, J_P),
        "m": rng.uniform(0.01, 0.03, n),
        "V0": rng.uniform(3e-5, 7e-5, n),
        "stiffness": rng.uniform(0.5, 2.0, n),
        "strength": rng.uniform(0.5, 2.0, n),
        "material": material,
    }


def both(core, precision, spline, transfer, rows):
    values = cloud(rows)
    lab = Lab(core, precision, spline, transfer, laws=rows, dx=DX, gravity=GRAVITY, **values)
    rounded = {
        name: a if name == "material" else np.asarray(a).astype(precision).astype(float)
        for name, a in values.items()
    }
    snow = Snow.table(rows, values["material"], rounded["stiffness"], rounded["strength"])
    p = step.Particles(*(rounded[name].copy() for name in NAMES), law=snow)
    return lab, p, step.Method(DX, spline, transfer, 0.95, GRAVITY)


def agree(lab, p, tolerance):
    got = lab.columns()
    for name, scale in SCALES.items():
        error = np.abs(got[name] - getattr(p, name)).max() / scale
        assert error <= tolerance, f"{name}: {error:.2e}"


@pytest.mark.parametrize("name", ["all mixed", *LAWS])
@pytest.mark.parametrize(("spline", "transfer"), ORDERS)
def test_steps(name, spline, transfer):
    """Ten steps with plastic flow in float64: 1e-12 of each quantity's size.

    A step rounds by 60 eps = 1.3e-14, LAPACK's share in the oracle; the dt resolves the waves, so errors add
    up rather than multiply: 10 steps, and 7 to spare. A return map brings states closer; through J_P the
    thresholds move by xi times its error.
    """
    rows = tuple(SOFT.values()) if name == "all mixed" else (SOFT[name],)
    lab, p, method = both(_core.f64, "float64", spline, transfer, rows)
    J_P = p.J_P.copy()
    for _ in range(10):
        lab.step(DT)
        step.step(p, method, DT)
    flowed = (np.abs(p.J_P / J_P - 1) > 1e-3).mean()
    assert flowed == 0 if "alone" in name else flowed > 0.1
    agree(lab, p, 1e-12)


@pytest.mark.parametrize("name", ["all mixed", *LAWS])
def test_single_precision(name):
    """One step in float32: 1e-5 of each quantity's size, as for one law in test_core_is_the_oracle."""
    rows = tuple(SOFT.values()) if name == "all mixed" else (SOFT[name],)
    lab, p, method = both(_core.f32, "float32", "quadratic", "apic", rows)
    lab.step(DT)
    step.step(p, method, DT)
    agree(lab, p, 1e-5)


def test_energy_of_mixed_packs():
    """The elastic energy that the core adds up over all laws at once is the oracle's, to 1e-12."""
    from reference import snow

    lab, p, _ = both(_core.f64, "float64", "quadratic", "apic", tuple(SOFT.values()))
    expected = (snow.energy(p.F_E, p.J_P, p.law) * p.V0).sum()
    assert _core.f64.totals(lab.model, lab.state).elastic == pytest.approx(expected, rel=1e-12)
