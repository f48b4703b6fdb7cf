"""The same bits: for any number of threads, and for a run that was stopped and resumed."""

import numpy as np
import pytest
from verification.scenes import ball, box, columns, march, scene

import neve

STEPS = 200


def busy(precision, spline, transfer, **numerics):
    """Lumps that collide, burst on a floor and a turning box, and drift through several sorts."""
    return scene(
        [
            box(center=(-0.2, 0.0, 0.1), size=(0.25, 0.25, 0.25), velocity=(6, 0, -5), spin=(0, 9, 3)),
            ball(center=(0.2, 0.03, 0.1), radius=0.15, velocity=(-6, 0, -5), snow={"xi": 5.0}),
        ],
        [
            {"shape": "plane", "point": (0, 0, -0.15), "normal": (0.1, 0, 1), "mu_c": 0.3},
            {"shape": "box", "center": (0, 0.1, -0.1), "size": (0.1, 0.1, 0.2), "spin": (0, 0, 9)},
            {
                "shape": "sphere", "center": (0.3, 0, -0.1), "radius": 0.1, "mode": "sticky",
                "keyframes": [{"t": 0, "position": (0.3, 0, -0.1)}, {"t": 0.1, "position": (0.2, 0, -0.1)}],
            },
        ],
        gravity=(0, 0, -9.81),
        precision=precision, spline=spline, transfer=transfer,  **numerics,
    )  # fmt: skip


def same(a, b):
    for name, value in columns(a).items():
        np.testing.assert_array_equal(value, columns(b)[name], err_msg=name)
    assert a.time == b.time
    assert a.steps == b.steps


def test_threads(spline, transfer):
    """One, two and three threads: every bit of every column after 200 steps, and of the sums over them."""
    compare_threads(busy("float32", spline, transfer, dt=2e-4), STEPS)


@pytest.mark.parametrize("transfer", ["apic", "flip"])
def test_threads_in_double(transfer):
    """The same in float64."""
    compare_threads(busy("float64", "quadratic", transfer, dt=2e-4), STEPS)


def test_threads_with_all_modes(spline):
    """The same with all 27 velocity modes."""
    compare_threads(busy("float32", spline, "polypic", polypic_modes=27, dt=2e-4), STEPS // 4)


def test_threads_choose_the_same_steps(precision):
    """The automatic time step follows from maxima over all particles, which threads must agree on."""
    compare_threads(busy(precision, "quadratic", "apic", dt="auto"), 50)


@pytest.mark.parametrize("cells", [(8, 8, 300), (300, 8, 8), (70, 70, 5)], ids=["tower", "row", "field"])
def test_threads_by_shape(cells):
    """Homes take turns in pieces of columns, cut otherwise for any number of threads; here with gaps."""
    runs = []
    for threads in (1, 2, 5):
        sim = neve.Simulation(scene([box(size=(0.5, 0.5, 1.25))]), threads=threads)
        x, v = sim.state.x, sim.state.v
        x[...] = np.random.default_rng(1).uniform(-0.5, 0.5, x.shape) * np.array(cells) * 0.05
        v[...] = np.sin(40 * np.array(x))
        before = columns(sim)
        sim.advance(20e-4)
        runs.append(sim)
    for other in runs[1:]:
        same(runs[0], other)
    after = columns(runs[0])
    gained = (after["m"][:, None] * (after["v"] - before["v"])).sum(axis=0)
    assert np.abs(gained).max() < 1e-10 * after["m"].sum()


def compare_threads(description, steps):
    runs = []
    for threads in (1, 2, 3):
        sim = neve.Simulation(description, threads=threads)
        for _ in range(2):
            sim.advance(steps / 2 * 2e-4)
        runs.append(sim)
    assert runs[0].steps >= steps
    start = np.array(neve.Simulation(description).state.x)
    moved = np.abs(columns(runs[0])["x"] - start).max()
    assert moved > 0.075 or steps < STEPS  # 1.5 cells, more than a block's tile forgives: there were sorts
    for other in runs[1:]:
        same(runs[0], other)
        assert runs[0].diagnostics() == other.diagnostics()


def test_twice(precision):
    """The same run again, to the bit."""
    description = busy(precision, "quadratic", "apic")
    same(march(neve.Simulation(description), 50), march(neve.Simulation(description), 50))


@pytest.mark.parametrize(("dt", "initial_volume"), [("auto", "grid"), (2e-4, "sampled")])
def test_resume_in_both_precisions(precision, spline, dt, initial_volume):
    """The default transfer, with steps chosen and fixed, and volumes from the grid and without."""
    compare_resumed(busy(precision, spline, "apic", dt=dt, initial_volume=initial_volume))


def test_resume(spline, transfer):
    """All transfers, with all that their particles carry."""
    compare_resumed(busy("float32", spline, transfer, dt=2e-4, polypic_modes=27))


def compare_resumed(description):
    """arrays() at any frame, then restore(): the run goes on with the same bits, whatever the threads.

    A frame is a call of advance(): 23 steps long, so that no sort falls on its end by design.
    """
    frame = 23 * 2e-4
    straight = neve.Simulation(description, threads=2)
    saved = [straight.arrays()]
    for _ in range(3):
        straight.advance(frame)
        saved.append({name: np.array(value) for name, value in straight.arrays().items()})
    for k in (0, 2):
        resumed = neve.Simulation.restore(description, saved[k], threads=1)
        for _ in range(3 - k):
            resumed.advance(frame)
        same(straight, resumed)


def test_arrays_are_a_copy():
    """What arrays() gave does not change when the simulation goes on."""
    sim = neve.Simulation(busy("float32", "quadratic", "apic"))
    saved = sim.arrays()
    before = saved["x"].copy()
    march(sim, 5)
    np.testing.assert_array_equal(saved["x"], before)
    assert not np.array_equal(np.asarray(sim.state.x), before)


def test_arrays_of_others_are_refused():
    """A simulation is restored from arrays of its own shapes and precision alone: nothing is broadcast."""
    sim = neve.Simulation(busy("float32", "quadratic", "apic"))
    arrays = sim.arrays()
    for name, wrong in (
        ("x", arrays["x"][:1]),
        ("J_P", arrays["J_P"].astype(np.float64)),
        ("v", arrays["m"]),
    ):
        with pytest.raises(ValueError, match=f"{name} is an array"):
            neve.Simulation.restore(sim.scene, {**arrays, name: wrong})
