"""Snow at rest that is not stepped: it stays, it wakes, and nothing else changes."""

import numpy as np
import pytest

from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.simulation import Simulation

SLEEPY = {"dx": 0.1, "sleep": True, "sleep_after": 0.05}
LAYER = {"shape": "box", "center": [0.0, 0.0, 0.2], "size": [4.0, 1.2, 0.4]}
BALL = {"shape": "sphere", "center": [-1.4, 0.0, 0.75], "radius": 0.15, "velocity": [0.0, 0.0, -3.0]}
GROUND = {"shape": "plane", "mode": "sticky"}
PADDLE = {
    "shape": "box",
    "center": [-4.0, 0.0, 0.6],
    "size": [0.2, 1.2, 1.0],
    "velocity": [2.0, 0.0, 0.0],
}


def scene(*sources, colliders=(GROUND,), **numerics):
    return scene_from(
        {
            "numerics": {**SLEEPY, **numerics},
            "sources": [LAYER, *sources],
            "colliders": list(colliders),
            "snow": {"E0": 1e6},
        }
    )


def asleep(sim):
    return sim.diagnostics().asleep


def by_id(sim, name="x"):
    return np.asarray(getattr(sim.state, name))[np.argsort(sim.state.id)].copy()


def settled(**more):
    """A run whose layer has come to rest."""
    sim = Simulation(scene(**more))
    for _ in range(20):
        sim.advance(0.05)
        if asleep(sim) == sim.state.count:
            return sim
    raise AssertionError(f"{asleep(sim)} of {sim.state.count} sleep")


def test_a_layer_falls_asleep_and_stays():
    """All of it sleeps; from then on not one bit of it changes, and its kinetic energy is nothing."""
    sim = settled()
    before, blocks = by_id(sim), sim.diagnostics().blocks
    sim.advance(0.1)
    assert asleep(sim) == sim.state.count
    assert np.array_equal(by_id(sim), before)
    assert sim.diagnostics().kinetic == 0.0
    assert blocks == 0


def test_what_sleeps_lies_as_it_would_awake():
    """Particles are within a tenth of a cell of a run that never sleeps."""
    sim, awake = settled(), Simulation(scene(sleep=False))
    awake.advance(sim.time)
    assert np.abs(by_id(sim) - by_id(awake)).max() < 0.1 * 0.1


def test_a_ball_wakes_what_it_hits():
    """A ball thrown onto one end of a sleeping layer: the same crater as in an awake run, the other end
    still sleeps, and mass is kept."""
    runs = []
    for sleep in (True, False):
        sim = Simulation(scene(sleep=False))
        sim.advance(0.1)
        sim.change(scene(sleep=sleep))
        for _ in range(6):
            sim.advance(0.05)
        if sleep:
            assert asleep(sim) == sim.state.count
        sim.add(scene(BALL).sources[1])
        for _ in range(6):
            sim.advance(0.05)
        runs.append(sim)
    sleepy, awake = runs
    assert 0 < asleep(sleepy) < sleepy.state.count
    x, y = by_id(sleepy), by_id(awake)
    far = x[:, 0] > 1.0
    assert np.isinf(by_id(sleepy, "rest")[far, 0]).mean() > 0.9
    near = (np.abs(x[:, 0] + 1.4) < 0.3) & (x[:, 2] > 0.2)
    assert np.median(np.abs(x - y)[near]) < 0.1 * 0.1
    assert sleepy.diagnostics().mass == pytest.approx(awake.diagnostics().mass, rel=1e-12)


def test_a_moving_solid_wakes_what_it_comes_to():
    """A paddle that sweeps along pushes sleeping snow before it as it pushes awake snow."""
    sim = settled(colliders=(GROUND, PADDLE))
    start = by_id(sim)
    for _ in range(9):
        sim.advance(0.1)
    moved = by_id(sim)[:, 0] - start[:, 0]
    assert 0 < asleep(sim) < sim.state.count
    assert moved.max() > 0.1


@pytest.mark.parametrize("change", [{"world": {"gravity": [4.0, 0.0, -9.0]}}, {"snow": {"E0": 3e6}}])
def test_a_change_of_the_scene_wakes_all(change):
    sim = settled()
    table = {
        "numerics": SLEEPY, "sources": [LAYER], "colliders": [GROUND], "snow": {"E0": 1e6}, **change
    }  # fmt: skip
    sim.change(scene_from(table))
    sim.advance(1e-3)
    assert asleep(sim) == 0


def test_a_velocity_that_is_written_counts():
    """Sleeping snow that a user pushes moves with that velocity, and what is not near it sleeps on."""
    sim = settled()
    pushed = np.asarray(sim.state.x)[:, 0] < -1.5
    ids = np.asarray(sim.state.id)[pushed]
    before = by_id(sim)[ids]
    sim.state.v[pushed] = (-3.0, 0.0, 1.0)
    sim.advance(0.05)
    assert (by_id(sim)[ids] - before)[:, 0].mean() < -0.05
    assert 0 < asleep(sim) < sim.state.count


def test_snow_falls_when_what_it_rests_on_is_taken_away():
    """A sink takes the lower half of sleeping snow; the upper half falls onto the ground."""
    hole = {"shape": "box", "center": [0, 0, 0.1], "size": [5.0, 4.0, 0.2], "start": 0.3, "end": 0.31}
    table = {
        "numerics": SLEEPY, "sources": [LAYER], "colliders": [GROUND], "snow": {"E0": 1e6}, "sinks": [hole]
    }  # fmt: skip
    sim = Simulation(scene_from(table))
    high = 0.0
    for k in range(12):
        sim.advance(0.05)
        if k == 4:
            assert asleep(sim) == sim.state.count
            high = sim.state.x[:, 2].max()
    assert sim.state.x[:, 2].max() < high - 0.1


def test_a_run_goes_on_with_sleep_or_without():
    """From a state that knows nothing of sleep, and the other way round; columns hold finite numbers."""
    sleepy, awake = settled(), Simulation(scene(sleep=False))
    awake.advance(0.01)
    for sim, sleep in ((sleepy, False), (awake, True)):
        other = Simulation.restore(scene(sleep=sleep), sim.arrays())
        other.advance(0.01)
        assert asleep(other) == 0
    columns = sleepy.columns()
    assert np.array_equal(columns["asleep"](), np.ones(sleepy.state.count))
    assert "rest" not in columns


def test_none_sleeps_while_gravity_changes():
    """Snow does not sleep before the last keyframe, and does after it."""
    table = {
        "numerics": SLEEPY, "sources": [LAYER], "colliders": [{**GROUND, "mode": "separate"}],
        "snow": {"E0": 1e6},
        "world": {"keyframes": [{"t": t, "gravity": [0, 0, -9.8]} for t in (0.0, 0.2)]},
    }  # fmt: skip
    sim = Simulation(scene_from(table))
    seen = []
    for _ in range(8):
        sim.advance(0.05)
        seen.append(asleep(sim))
    assert seen[:4] == [0] * 4
    assert seen[-1] == sim.state.count


def test_same_bits_on_any_number_of_threads_and_after_a_resume():
    """With snow that falls asleep, sleeps and is woken."""
    runs = []
    for threads, break_at in ((1, None), (2, None), (2, 6)):
        sim = Simulation(scene(BALL), threads=threads)
        seen = []
        for k in range(14):
            sim.advance(0.05)
            seen.append(asleep(sim))
            if k == break_at:
                sim = Simulation.restore(sim.scene, sim.arrays(), threads=threads)
        assert max(seen) > 0
        runs.append((seen, by_id(sim), by_id(sim, "F_E"), by_id(sim, "rest")))
    for run in runs[1:]:
        assert run[0] == runs[0][0]
        assert all(np.array_equal(a, b) for a, b in zip(run[1:], runs[0][1:], strict=True))


def test_snow_that_arrives_wakes_snow_and_goes_on_exactly():
    """An emitter drops snow onto sleeping snow and a sink takes some of it: the same bits after a resume, and
    no mass that the books do not know."""
    table = {
        "numerics": SLEEPY,
        "sources": [LAYER],
        "colliders": [GROUND],
        "snow": {"E0": 1e6},
        "emitters": [
            {"shape": "box", "center": [-1.4, 0.0, 0.9], "size": [0.3, 0.3, 0.2], "velocity": [0, 0, -2.0],
             "mass_rate": 20.0, "start": 0.2}
        ],
        "sinks": [{"shape": "box", "center": [-1.4, 0.0, 0.4], "size": [0.4, 0.4, 0.3], "start": 0.5}],
    }  # fmt: skip
    straight, broken = Simulation(scene_from(table)), Simulation(scene_from(table), threads=1)
    mass, seen = straight.diagnostics().mass, []
    for k in range(14):
        straight.advance(0.05)
        broken.advance(0.05)
        seen.append(asleep(straight))
        assert np.isinf(straight.state.rest[:, 0]).sum() == seen[-1]
        if k == 9:
            broken = Simulation.restore(broken.scene, broken.arrays())
    totals = straight.diagnostics()
    assert 0 < seen[-1] < seen[3] == max(seen)
    assert totals.emitted_mass > 0.0 < totals.removed_mass
    assert totals.mass == pytest.approx(mass + totals.emitted_mass - totals.removed_mass, rel=1e-9)
    for name in ("x", "F_E", "rest"):
        assert np.array_equal(by_id(straight, name), by_id(broken, name))


@pytest.mark.parametrize(
    ("numerics", "words"),
    [
        ({"device": "cuda"}, 'sleep = true .* with numerics.device = "cuda": set "cpu" or "auto"'),
        ({"sleep_speed": 0.0}, "numerics.sleep_speed"),
        ({"sleep_after": -1.0}, "numerics.sleep_after"),
    ],
)
def test_refused(numerics, words):
    with pytest.raises(SceneError, match=words):
        scene(**numerics)
