"""Particles at rest that are not stepped: they stay, they wake by each cause, and nothing else changes."""

from itertools import pairwise

import numpy as np
import pytest
from verification.particles.common import columns, energy, particles

import neve
from neve.scene.schema.scene import Scene

SLEEPY = {"sleep": True, "sleep_speed": 0.01, "sleep_after": 0.1}
LAYER = {"shape": "box", "center": (0, 0, 0.1), "size": (1.2, 0.4, 0.2)}
BALL = {"shape": "sphere", "center": (-0.45, 0, 0.35), "radius": 0.08, "velocity": (0, 0, -3.0)}
SNOW = {"E0": 2e5, "theta_s": 0.02}
GROUND = {"shape": "plane", "mu_c": 0.8}
MOST = 0.96  # of the particles; loose ends at the surface swing for long
PADDLE = {"shape": "box", "center": (-1.6, 0, 0.25), "size": (0.1, 0.5, 0.4), "velocity": (1.0, 0, 0)}


def layer(*sources, colliders=(GROUND,), gravity=(0, 0, -9.81), snow=SNOW, threads=1, **numerics):
    return particles(
        [LAYER, *sources],
        colliders,
        gravity,
        snow,
        threads=threads,
        **{**SLEEPY, "precision": "float32", **numerics},
    )


def settled(**more):
    """Make a layer nearly all of whose particles have fallen asleep."""
    sim = layer(**more)
    for _ in range(18):
        sim.advance(0.05)
        if asleep(sim) > MOST * sim.count:
            return sim
    raise AssertionError(f"{asleep(sim)} of {sim.count} sleep")


def asleep(sim):
    return sim.diagnostics().asleep


def x_of(sim):
    return columns(sim)["x"]


def sleepers(sim):
    """Which particles sleep, by birth number."""
    order = np.argsort(np.asarray(sim.state.id))
    return np.isinf(np.asarray(sim.state.rest)[order, 0])


def test_a_layer_falls_asleep_and_stays():
    """Not one bit of what sleeps changes, it does not move, and more falls asleep; the contacts are kept."""
    sim = settled()
    before, slept, bonds = x_of(sim), sleepers(sim), sim.diagnostics().bonds
    sim.advance(0.05)
    both = slept & sleepers(sim)
    assert both.mean() > MOST - 0.02
    assert np.array_equal(x_of(sim)[both], before[both])
    assert np.array_equal(columns(sim)["v"][both], np.zeros((both.sum(), 3)))
    assert sim.diagnostics().bonds >= 0.999 * bonds
    assert np.array_equal(np.sort(sim.columns()["asleep"]()), np.sort(sleepers(sim)))
    assert "rest" not in sim.columns()


def test_what_sleeps_lies_as_it_would_awake():
    """Particles are within a tenth of a radius of a run that never sleeps, but for loose ends."""
    sim, awake = settled(), layer(sleep=False)
    awake.advance(sim.time)
    radius = float(np.mean(sim.state.radius))
    off = np.linalg.norm(x_of(sim) - x_of(awake), axis=1)
    assert np.percentile(off, 97) < 0.1 * radius


def test_a_ball_wakes_what_it_hits():
    """A ball thrown onto one end: the crater of an awake run to half a radius, the other end sleeps on;
    energy less the work of solids only falls.
    """
    runs = []
    for sleep in (True, False):
        sim = layer(sleep=False)
        sim.advance(0.1)
        sim.change(
            sim.scene.model_copy(update={"numerics": sim.scene.numerics.model_copy(update={"sleep": sleep})})
        )
        sim.advance(0.35)
        if sleep:
            assert asleep(sim) > 0.65 * sim.count
        sim.add(Scene.model_validate({"sources": [BALL]}).sources[0])
        last = energy(sim)
        for _ in range(10):
            sim.advance(0.02)
            assert energy(sim) <= last + 5e-3 * abs(last)
            last = energy(sim)
        runs.append(sim)
    sleepy, awake = runs
    assert 0 < asleep(sleepy) < sleepy.count
    x, y = x_of(sleepy), x_of(awake)
    first = np.asarray(sleepy.state.rest)[np.argsort(np.asarray(sleepy.state.id)), 0]
    far = x[:, 0] > 0.4
    assert np.isinf(first[far]).mean() > 0.85
    radius = float(np.mean(sleepy.state.radius))
    near = (np.abs(x[:, 0] + 0.45) < 0.15) & (x[:, 2] > 0.05)
    assert np.median(np.abs(x - y)[near]) < 0.5 * radius
    top = lambda z: np.percentile(z[near, 2], 95)  # noqa: E731
    assert top(x) == pytest.approx(top(y), abs=radius)


def test_a_moving_solid_wakes_what_it_comes_to():
    """A paddle shoves sleeping snow as it shoves snow that is awake: the same share moves as far."""
    shoved = []
    for sleep in (True, False):
        sim = layer(colliders=(GROUND, PADDLE), sleep=sleep)
        sim.advance(0.3)
        start = x_of(sim)
        if sleep:
            assert asleep(sim) > 0.65 * sim.count
        for _ in range(11):
            sim.advance(0.1)
        if sleep:
            assert asleep(sim) < 0.65 * sim.count
        shoved.append(x_of(sim)[:, 0] - start[:, 0])
    assert shoved[0].max() > 0.1
    moved = [(s > 0.05).mean() for s in shoved]
    assert moved[0] == pytest.approx(moved[1], abs=0.05)


TURNS = [
    {"t": 1.0, "position": (-0.9, 0, 0.45), "rotation": (0, 0, 0)},
    {"t": 1.06, "position": (-0.5, 0, 0.32), "rotation": (0, 70, 0)},
    {"t": 1.1, "position": (-0.5, 0, 0.32), "rotation": (0, 70, 0)},
    {"t": 1.16, "position": (-0.2, 0, 0.24), "rotation": (0, 200, 40)},
]


@pytest.mark.parametrize(
    ("shape", "play"),
    [({"shape": "box", "size": (0.4, 0.2, 0.06)}, 1.5), ({"shape": "mesh", "file": "neve:boot"}, 0.0)],
)
def test_no_snow_sleeps_beside_a_solid_that_moves(shape, play):
    """After each step what sleeps is farther from a solid that moves, turns, rests and moves on than
    1.5 radii; from a mesh it may be nearer by what its samples are coarse.
    """
    sim = settled(colliders=(GROUND, {**shape, "keyframes": TURNS}))
    sim.advance(1.0 - sim.time)
    slept = asleep(sim)
    state, nearest, seen = sim.state, [], []

    def look():
        sleeps = np.isinf(np.asarray(state.rest)[:, 0])
        gap = sim.solver.placed.distance(1, np.asarray(state.x)) - np.asarray(state.radius)
        nearest.append(gap[sleeps].min())
        seen.append(sleeps.sum())
        return False

    for begin, end in pairwise((1.0, 1.06, 1.1, 1.16)):
        sim.advance(end - begin, look)
        if begin != 1.06:  # while it rests snow may fall asleep beside it
            assert min(nearest) > play * state.largest_radius * (1 - 1e-5)
        nearest.clear()
    assert min(seen) < slept - 0.05 * sim.count


def test_a_body_that_falls_wakes_snow():
    body = {"shape": "sphere", "center": (0.3, 0, 0.7), "radius": 0.08, "density": 300.0}
    scene = {
        "world": {"gravity": (0, 0, -9.81)},
        "numerics": {"method": "particles", "dx": 0.05, **SLEEPY},
        "snow": SNOW, "sources": [LAYER], "colliders": [GROUND], "bodies": [body],
    }  # fmt: skip
    sim = neve.Simulation(Scene.model_validate(scene), threads=1)
    sim.advance(0.28)
    most = asleep(sim)
    assert most > 0.65 * sim.count
    sim.advance(0.17)
    assert asleep(sim) < most
    assert sim.solids()[1][1].position[2] > 0.15


@pytest.mark.parametrize("change", [{"world": {"gravity": (4.0, 0, -9.0)}}, {"snow": {"E0": 4e5}}])
def test_a_change_of_the_scene_wakes_all(change):
    sim = settled()
    table = {
        "world": {"gravity": (0, 0, -9.81)},
        "numerics": {"method": "particles", "dx": 0.05, **SLEEPY},
        "snow": SNOW, "sources": [LAYER], "colliders": [GROUND], **change,
    }  # fmt: skip
    sim.change(Scene.model_validate(table))
    sim.advance(1e-3)
    assert asleep(sim) == 0


def test_what_is_written_counts():
    """Sleeping snow that a user pushes or lifts moves, and what is not near it sleeps on."""
    for name, value in (("v", (-2.0, 0, 1.0)), ("x", None)):
        sim = settled()
        pushed = np.asarray(sim.state.x)[:, 0] < -0.5
        ids = np.asarray(sim.state.id)[pushed]
        if value is None:
            sim.state.x[pushed] += (0, 0, 0.3)
        else:
            getattr(sim.state, name)[pushed] = value
        before = x_of(sim)[ids]
        sim.advance(0.05)
        assert np.linalg.norm(x_of(sim)[ids] - before, axis=1).mean() > 0.005
        assert 0 < asleep(sim) < sim.count


def test_snow_falls_when_what_holds_it_breaks():
    """A slab lies asleep on a table that is drawn away from under it: it falls."""
    table = {
        "shape": "box", "center": (0, 0, -0.1), "size": (2.0, 1.0, 0.2),
        "keyframes": [{"t": 0.5, "position": (0, 0, -0.1)}, {"t": 0.6, "position": (0, 0, -0.6)}],
    }  # fmt: skip
    sim = layer(colliders=(table,))
    sim.advance(0.45)
    assert asleep(sim) > 0.9 * sim.count
    high = x_of(sim)[:, 2].mean()
    sim.advance(0.3)
    assert x_of(sim)[:, 2].mean() < high - 0.1


def test_none_sleeps_while_gravity_changes():
    table = {
        "world": {"keyframes": [{"t": t, "gravity": (0, 0, -9.8)} for t in (0.0, 0.3)]},
        "numerics": {"method": "particles", "dx": 0.05, **SLEEPY},
        "snow": SNOW, "sources": [LAYER], "colliders": [GROUND],
    }  # fmt: skip
    sim = neve.Simulation(Scene.model_validate(table), threads=1)
    sim.advance(0.15)
    sim.advance(0.1)
    assert asleep(sim) == 0
    for _ in range(4):
        sim.advance(0.1)
    assert asleep(sim) > 0.9 * sim.count


def test_heat_wakes_what_it_melts():
    """Snow that sleeps in the cold melts and wakes when the air is warm; the balance of heat holds."""
    table = {
        "world": {"gravity": (0, 0, -9.81)},
        "numerics": {"method": "particles", "dx": 0.05, **SLEEPY},
        "snow": SNOW, "sources": [LAYER], "colliders": [GROUND],
        "heat": {"snow_temperature": -0.5, "air_temperature": -5.0, "heat_speed": 100.0},
    }  # fmt: skip
    sim = neve.Simulation(Scene.model_validate(table), threads=1)
    sim.advance(0.3)
    assert asleep(sim) > 0.65 * sim.count
    first = sim.diagnostics()
    warm = {**table, "heat": {**table["heat"], "air_temperature": 30.0, "heat_speed": 30000.0}}
    sim.change(Scene.model_validate(warm))
    sim.advance(0.3)
    now = sim.diagnostics()
    assert now.water > 0.0
    assert now.asleep < 0.5 * first.asleep
    assert now.heat - first.heat == pytest.approx(now.heat_taken - first.heat_taken, rel=1e-9)


def test_same_bits_on_any_number_of_threads_and_after_a_resume():
    """With snow that falls asleep, sleeps, is hit and woken: everything that is saved is the same."""
    runs = []
    for threads, break_at in ((1, None), (2, None), (3, 7), (1, 9)):
        sim = layer(BALL | {"center": (-0.45, 0, 1.2)}, threads=threads)
        seen = []
        for k in range(14):
            sim.advance(0.03)
            seen.append(asleep(sim))
            if k == break_at:
                sim = neve.Simulation.restore(sim.scene, sim.arrays(), threads=threads)
                assert asleep(sim) == seen[-1]
        assert 0 < max(seen) < sim.count
        assert any(later < earlier for earlier, later in pairwise(seen)), "none was woken"
        runs.append((seen, sim.arrays()))
    for seen, arrays in runs[1:]:
        assert seen == runs[0][0]
        for name, value in runs[0][1].items():
            np.testing.assert_array_equal(arrays[name], value, err_msg=name)


def test_a_run_goes_on_with_sleep_or_without():
    sleepy = settled()
    for sleep in (False, True):
        numerics = sleepy.scene.numerics.model_copy(update={"sleep": sleep})
        other = neve.Simulation.restore(
            sleepy.scene.model_copy(update={"numerics": numerics}), sleepy.arrays()
        )
        other.advance(0.01)
        assert asleep(other) > MOST * other.count if sleep else asleep(other) == 0
