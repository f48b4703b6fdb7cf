"""Two particles: a bond vibrates and breaks, a contact bounces and rubs, as single springs do."""

import math

import numpy as np
import pytest
from verification.particles.common import energy, pair_of_particles

from neve.particles.constants import DAMPING, NEVER, contact_constants
from neve.scene.schema.scene import Snow
from neve.scene.schema.snow_kinds import SNOWS
from neve.scene.values.choices import LAWS

NEVER_YIELDS = {"law": "drucker_prager", "cohesion": 0.0, "E0": 1e5, "friction_angle": 20.0}


def x_of(sim, number):
    """Return place and velocity along x of the particle with this birth number."""
    row = int(np.flatnonzero(np.asarray(sim.state.id) == number)[0])
    return float(sim.state.x[row, 0]), float(sim.state.v[row, 0])


def test_period_of_a_bond():
    """Two particles of mass m on a spring k swing with w^2 = 2 k / m, less what the damper takes.

    Half a period from the largest stretch to the least is pi / (w sqrt(1 - DAMPING^2)).
    """
    sim, r = pair_of_particles(0.0, snow={"plasticity": "none"}, bonded=True)
    k, m = float(sim.state.k[0]), float(sim.state.m[0])
    assert k == pytest.approx(sim.scene.snow.E0 * r)
    row = int(np.flatnonzero(np.asarray(sim.state.id) == 1)[0])
    sim.state.x[row, 0] += 0.01 * r
    w = math.sqrt(2 * k / m)
    half = math.pi / (w * math.sqrt(1 - DAMPING**2))
    least, when = math.inf, 0.0
    for _ in range(400):
        sim.advance(1.5 * half / 400)
        gap = x_of(sim, 1)[0] - x_of(sim, 0)[0] - 2 * r
        if gap < least:
            least, when = gap, sim.time
    assert when == pytest.approx(half, rel=0.02)
    assert -least == pytest.approx(0.01 * r * math.exp(-DAMPING * w * half), rel=0.03)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_strength_of_a_bond(share):
    """A bond that is stretched by bond_strain of the distance breaks, by less it holds.

    Without damping a start with the speed v stretches it by v / w.
    """
    snow = {"theta_s": 0.02}
    sim, r = pair_of_particles(0.0, snow=snow, bonded=True)
    sim.state.set_law(0.0, 0.5, 917.0, 100.0)
    sim.solver._derive = lambda: None  # keep the damper off
    k, m = float(sim.state.k[0]), float(sim.state.m[0])
    w = math.sqrt(2 * k / m)
    stretch = share * 0.02 * 2 * r
    for number, sign in ((0, -1), (1, 1)):
        row = int(np.flatnonzero(np.asarray(sim.state.id) == number)[0])
        sim.state.v[row, 0] = sign * stretch * w / 2
    assert sim.diagnostics().bonds == 1
    sim.advance(3 / w)
    assert sim.diagnostics().bonds == (1 if share < 1 else 0)


def test_bounce():
    """A contact with the damping ratio z throws back the share e of the speed, and never pulls.

    A spring and a damper that act until their force is zero, at w s t = pi - atan(2 z s / (1 - 2 z^2)) with
    s = sqrt(1 - z^2), give e = exp(-z w t).
    """
    sim, _ = pair_of_particles(0.001, speed=-0.2, snow=NEVER_YIELDS)
    sim.advance(0.05)
    apart = x_of(sim, 1)[1] - x_of(sim, 0)[1]
    z = DAMPING
    s = math.sqrt(1 - z * z)
    e = math.exp(-z / s * (math.pi - math.atan(2 * z * s / (1 - 2 * z * z))))
    assert apart == pytest.approx(0.2 * e, rel=0.02)
    assert x_of(sim, 1)[1] + x_of(sim, 0)[1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("wet", [(0,), (1,), (0, 1)])
def test_a_drop_hardly_bounces(wet):
    """A contact of water with snow or water has the damping ratio z = 1.5, whatever its stiffness.

    A spring and a damper that act until their force is zero give e = ((z - s) / (z + s))^(z / s) with
    s = sqrt(z^2 - 1): 0.076.
    """
    sim, r = pair_of_particles(0.001, speed=-0.2, snow=NEVER_YIELDS)
    for number in wet:
        sim.state.liquid[number] = 1.0
    k = sim.scene.snow.E0 * r
    sim.advance(0.1)
    stiffness = sorted(float(sim.state.k[np.asarray(sim.state.id) == number][0]) / k for number in (0, 1))
    assert stiffness == pytest.approx(sorted(0.1 if number in wet else 1.0 for number in (0, 1)))
    assert x_of(sim, 1)[0] - x_of(sim, 0)[0] > 2 * r
    apart = x_of(sim, 1)[1] - x_of(sim, 0)[1]
    s = math.sqrt(1.5**2 - 1)
    assert apart == pytest.approx(0.2 * ((1.5 - s) / (1.5 + s)) ** (1.5 / s), rel=0.05)
    assert apart < 0.1 * 0.2


def test_energy_of_a_bounce_falls():
    """The energy of two particles that meet off centre only falls, but for the swing of explicit steps."""
    sim, r = pair_of_particles(0.05, speed=-1.0, snow=NEVER_YIELDS)
    row = int(np.flatnonzero(np.asarray(sim.state.id) == 1)[0])
    sim.state.x[row, 2] = 0.8 * r
    start = energy(sim)
    sim.advance(0.2)
    assert 0.3 * start < energy(sim) < start


# law -> snow, and its modulus [Pa], friction, bond strain, yield pressure [Pa] by hand (docs/particles.md)
BY_HAND = {
    "stomakhin2013": ({"kind": "reference"}, (1.4e5, 0.7813, 0.0075, 3500.0)),  # tan 38; 1.4e5 x 0.025
    "neo_hookean": (
        {"law": "neo_hookean", "E0": 2e5, "theta_c": 0.02, "theta_s": 0.006},
        (2e5, 0.7813, 0.006, 4000.0),  # 2e5 x 0.02
    ),
    "hencky": (
        {"law": "hencky", "E0": 8e4, "theta_c": 0.03, "theta_s": 0.005},
        (8e4, 0.7813, 0.005, 2400.0),  # 8e4 x 0.03
    ),
    "drucker_prager": (
        {"law": "drucker_prager", "E0": 1e5, "friction_angle": 30.0, "cohesion": 500.0},
        (1e5, 0.5774, 0.005, NEVER),  # tan 30; 500 / 1e5
    ),
    "cam_clay": ({"kind": "wet"}, (6e5, 0.4743, 0.013333, 1e4)),  # sin phi = 3 / 7; 0.8 x 1e4 / 6e5
}


@pytest.mark.parametrize("law", LAWS)
def test_constants_by_hand(law):
    """One snow of each law; without plasticity nothing breaks or yields."""
    given, numbers = BY_HAND[law]
    assert contact_constants(Snow.model_validate(given)) == pytest.approx(numbers, rel=1e-4)
    if LAWS[law].has_elastic_option:
        elastic = contact_constants(Snow.model_validate({"law": law, "E0": 3e4, "plasticity": "none"}))
        assert elastic == pytest.approx((3e4, 0.7813, NEVER, NEVER), rel=1e-4)


def test_constants_of_named_snows():
    """Every law has finite constants: E0, the strain and the pressure at which its own snow flows."""
    for kind in SNOWS:
        snow = Snow.model_validate({"kind": kind})
        c = contact_constants(snow)
        assert c.modulus == snow.E0
        assert 0 < c.friction < 3
        assert 0 <= c.bond_strain < 1
        assert c.yield_pressure > 0
