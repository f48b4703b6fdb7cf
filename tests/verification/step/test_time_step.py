"""The time step: fixed or automatic, and what bound it."""

import numpy as np
import pytest
from reference.snow import Snow
from verification.scenes import ball, scene, simulate

C_P = np.sqrt(Snow().M_c / Snow().rho0)  # 19.72 m/s


def simulation(**numerics):
    speed = numerics.pop("speed", 0.0)
    snow = numerics.pop("snow", {})
    return simulate(scene([ball(velocity=(0, 0, -speed))], snow=snow, initial_volume="sampled", **numerics))


def test_fixed():
    """numerics.dt is taken as it is when it divides the time, and never exceeded when it does not."""
    sim = simulation(dt=1e-4)
    sim.advance(1e-3)
    assert sim.steps == 10
    assert sim.stats.bound == "fixed"
    assert sim.stats.dt_min == pytest.approx(1e-4, rel=1e-9)
    sim.advance(2.5e-4)
    assert sim.steps == 13
    assert sim.time == pytest.approx(1.25e-3, rel=1e-12)
    assert sim.stats.dt_mean == pytest.approx(2.5e-4 / 3, rel=1e-9)


@pytest.mark.parametrize(("speed", "bound"), [(0.0, "wave"), (5.0, "wave"), (50.0, "speed")])
def test_automatic(speed, bound):
    """dt = cfl dx / (c + |v|) with c = sqrt(M_c V0 / m): the steps that fit into the time, divided evenly.

    ceil(T / dt) steps of T / ceil(T / dt) each; the snow is still fresh and undeformed, so c is c_p
    throughout.
    """
    sim = simulation(dt="auto", cfl=0.3, speed=speed)
    dt = 0.3 * 0.05 / (C_P + speed)
    total = 10.5 * dt
    sim.advance(total)
    assert sim.stats.steps == 11
    assert sim.stats.dt_mean == pytest.approx(total / 11, rel=1e-6)
    assert sim.stats.dt_min <= dt
    assert sim.stats.bound == bound


def test_hardening_shortens_the_step():
    """c = sqrt(exp(xi (1 - J_P)) M_c V0 / m).

    At J_P = 0.6 and xi = 10 e^2 = 7.39 times the fresh speed, 146 m/s.
    """
    sim = simulation(dt="auto", cfl=0.4)
    sim.state.J_P[:] = 0.6
    c = C_P * np.exp(2.0)
    assert c == pytest.approx(146, abs=0.5)
    dt = 0.4 * 0.05 / c
    sim.advance(dt * 3.5)
    assert sim.stats.steps == 4
    assert sim.stats.bound == "wave"


def test_stiffness_counts():
    """A stiffness factor of 4 on one particle halves the step."""
    sim = simulation(dt="auto", cfl=0.4)
    sim.state.stiffness[5] = 4.0
    sim.advance(0.4 * 0.05 / (2 * C_P) * 3.5)
    assert sim.stats.steps == 4


def test_dt_max():
    """Soft, slow snow is held by dt_max."""
    sim = simulation(dt="auto", dt_max=1e-3, snow={"E0": 10.0})
    sim.advance(1e-2)
    assert sim.stats.steps == 10
    assert sim.stats.bound == "dt_max"


def test_time_adds_up():
    """Many frames of 1/30 s.

    The time is their sum to a rounding each, and stats count from the last frame.
    """
    sim = simulation(dt="auto")
    for _ in range(10):
        before = sim.steps
        sim.advance(1 / 300)
        assert sim.stats.steps == sim.steps - before
    assert sim.time == pytest.approx(10 / 300, rel=1e-14)


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.nan, np.inf])
def test_no_such_time(seconds):
    """A time that is not positive and finite is refused."""
    with pytest.raises(ValueError, match="seconds"):
        simulation().advance(seconds)


def test_smaller_steps_converge(transfer):
    """Halving dt of an elastic, falling, spinning ball halves the difference to the finest: first order.

    Symplectic Euler's error is c dt: (e(4 dt) - e(dt)) / (e(2 dt) - e(dt)) = 3. FLIP with alpha = 1, whose
    damping does not depend on dt; between 2 and 4 is asked for, since dt^2 and the clamp add their part.
    """
    ends = []
    for dt in (4e-4, 2e-4, 1e-4):
        sim = simulate(
            scene(
                [ball(spin=(0, 8, 0), velocity=(0, 0, 3))],
                gravity=(0, 0, -9.81),
                dt=dt,
                transfer=transfer,
                flip_alpha=1.0,
                initial_volume="sampled",
            )
        )
        sim.advance(0.02)
        order = np.argsort(np.asarray(sim.state.id))
        ends.append(np.array(sim.state.x)[order])
    ratio = np.linalg.norm(ends[0] - ends[2]) / np.linalg.norm(ends[1] - ends[2])
    assert 2 < ratio < 4


def test_a_fixed_step_beyond_the_limit_is_told(caplog):
    """dt = 4e-3 s against courant dx / c = 1.5e-3 s: one warning, with a better value; 1e-4 s has none.

    courant = sqrt(2 / 4 / 1.5) for apic with nu = 0.2 (test_stable_step.py).
    """
    with caplog.at_level("WARNING", logger="neve"):
        simulation(dt=1e-4).advance(1e-3)
        assert not caplog.records
        sim = simulation(dt=4e-3)
        sim.advance(4e-3)
        sim.advance(4e-3)
    (record,) = caplog.records
    text = record.getMessage()
    assert f"beyond the limit of {3**-0.5 * 0.05 / C_P:.3g} s" in text
    assert f"use at most {0.4 * 0.05 / C_P:.3g} s" in text
