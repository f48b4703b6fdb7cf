"""Particles in contact that come out of emitters and go into sinks: rates, books, sleep and bits."""

import numpy as np
import pytest

import neve
from neve.particles.constants import radius_at_birth
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Source
from neve.solver import Blowup

NOZZLE = {"shape": "box", "size": [0.1, 0.2, 0.2], "velocity": [2, 0, 0], "center": [0, 0, 0]}
SLEEPY = {"sleep": True, "sleep_speed": 0.02, "sleep_after": 0.1, "precision": "float32"}


def world(gravity=0.0, emitters=(NOZZLE,), threads=1, **more):
    numerics = {"method": "particles", "dx": 0.05, "precision": "float64", **more.pop("numerics", {})}
    snow = {"E0": 2e4, **more.pop("snow", {})}
    tables = {"world": {"gravity": [0, 0, -gravity]}, "numerics": numerics, "snow": snow, **more}
    tables["emitters"] = [*emitters]
    return neve.Simulation(scene_from(tables), threads=threads)


def momentum_excess(sim, start=(0.0, 0.0, 0.0)):
    """Return the momentum that nothing accounts for [kg m/s], and the sum of all that came and went."""
    d = sim.diagnostics()
    came, went = np.array(d.emitted_momentum), np.array(d.removed_momentum)
    return np.array(d.momentum) - start - (came - went), np.abs(came).sum() + np.abs(went).sum()


def balance(sim):
    """Return the energy of the snow without what came, went and what colliders did [J]."""
    d = sim.diagnostics()
    return d.kinetic + d.elastic + d.potential - d.work - d.emitted_energy + d.removed_energy


def settle(sim, time):
    """Let snow fall asleep until `time` [s]; three quarters of it have then."""
    while sim.time < time - 1e-9:
        sim.advance(min(0.05, time - sim.time))
    assert sim.diagnostics().asleep > 0.75 * sim.count


def test_a_jet_is_snow_at_rest_in_itself():
    """Without gravity a full jet flies on as a block: bonded, free of stress, with its mass and velocity.

    A layer is 8 x 8 particles in 1/40 m; 0.25 s at 2 m/s make 20 layers.
    """
    sim = world()
    for _ in range(5):
        sim.advance(0.05)
    d = sim.diagnostics()
    assert sim.count == 20 * 8 * 8
    assert d.mass == pytest.approx(400 * 0.04 * 2 * 0.25, rel=1e-12)
    np.testing.assert_allclose(sim.state.v, np.tile([2.0, 0, 0], (sim.count, 1)), atol=1e-9)
    assert d.elastic < 1e-12 * d.kinetic
    assert d.bonds > 2.0 * sim.count
    radius = radius_at_birth(0.04 * 0.025 / 64)
    np.testing.assert_allclose(sim.state.radius, radius, rtol=1e-12)


def test_a_falling_jet_is_ballistic():
    """The mean place and velocity are those of free fall, with the bounds of tests/verification/flow."""
    t = 0.25
    sim = world(gravity=9.81)
    sim.advance(t)
    x, v = (np.asarray(column).mean(axis=0) for column in (sim.state.x, sim.state.v))
    assert x == pytest.approx([t, 0, -9.81 * t * t / 6], abs=2e-3)
    assert v == pytest.approx([2.0, 0, -9.81 * t / 2], abs=5e-3)


def test_mass_and_momentum_close_in_a_collision():
    """Two jets meet, and a sink takes what flies through it: mass and momentum are what came less what went.

    To the rounding of sums in double: no collider and no gravity take part.
    """
    other = {**NOZZLE, "center": [0.5, 0.05, 0], "velocity": [-3, 0, 0], "spread": 10, "mass_rate": 20.0}
    sink = {"shape": "box", "center": [0.25, 0, 0.2], "size": [1, 1, 0.15]}
    sim = world(emitters=(NOZZLE, other), sinks=[sink])
    before = 0.0
    for _ in range(8):
        sim.advance(0.03)
        d = sim.diagnostics()
        assert d.mass == pytest.approx(d.emitted_mass - d.removed_mass, rel=1e-12)
        wrong, scale = momentum_excess(sim)
        assert np.abs(wrong).max() < 1e-12 * scale
        now = balance(sim)
        assert now <= before + 1e-9 * d.emitted_energy
        before = now
    assert d.removed_mass > 0.05
    assert balance(sim) < -0.1 * d.emitted_energy  # what breaks is lost


def test_what_goes_takes_the_energy_of_its_bonds():
    """A pressed block loses to a sink what its bonds stored, those that are cut as well, in 1e-7 s.

    With w = sqrt(sum k / m) < 1e4 / s, w dt = 1e-3: a step of so short a time changes the sum by its square.
    """
    block = {"shape": "box", "size": [0.3, 0.2, 0.2], "velocity": [0.0, 0, 0]}
    sink = {"shape": "box", "center": [0.15, 0, 0], "size": [0.31, 1, 2], "start": 1e-7}
    sim = world(emitters=(), sources=[block], sinks=[sink], snow={"plasticity": "none"})
    sim.state.x[...] *= 0.98  # pressed
    sim.state.rest[...] = 0.0
    sim.advance(1e-9)
    before = sim.diagnostics()
    sim.advance(1e-7)
    after = sim.diagnostics()
    assert 0.3 < after.removed_mass / before.mass < 0.8
    assert after.elastic < 0.8 * before.elastic
    assert after.removed_energy + after.elastic + after.kinetic == pytest.approx(before.elastic, rel=1e-6)


def test_snow_born_inside_snow_pushes_nothing_at_once():
    """A nozzle inside a block at rest: what is born there is free of stress, and no energy comes of it."""
    block = {"shape": "box", "size": [0.4, 0.4, 0.4]}
    slow = {**NOZZLE, "velocity": [0.05, 0, 0]}
    sim = world(emitters=(slow,), sources=[block], snow={"cohesion": 0.0, "law": "drucker_prager"})
    sim.advance(0.02)
    before = balance(sim)
    for _ in range(6):
        sim.advance(0.25)
        d = sim.diagnostics()
        now = balance(sim)
        assert now <= before + 1e-9
        assert np.linalg.norm(sim.state.v, axis=1).max() < 0.5
        before = now
    assert d.emitted_mass > 0.5


def scene_of_all(**more):
    """Snow that comes, falls, heats, sleeps and goes."""
    return {
        "world": {"gravity": [0, 0, -9.81]},
        "numerics": {"method": "particles", "dx": 0.05, **SLEEPY, "sleep_speed": 0.1, "sleep_after": 0.05},
        "snow": {"E0": 1e5},
        "heat": {"air_temperature": 20.0, "snow_temperature": 0.0, "heat_speed": 30.0},
        "sources": [
            {"shape": "box", "size": [0.6, 0.3, 0.1], "center": [0.2, 0, -0.35]},
            {"shape": "box", "size": [0.3, 0.3, 0.1], "center": [3.0, 0, -0.35]},
        ],
        "emitters": [
            {**NOZZLE, "spread": 10, "mass_rate": 8.0, "end": 0.3},
            {**NOZZLE, "center": [0, 0, 0.3], "start": 0.02, "velocity": [2, 0, -1]},
        ],
        "sinks": [{"shape": "box", "center": [0.45, 0, -0.35], "size": [0.2, 1, 0.1], "start": 0.15}],
        "colliders": [{"shape": "plane", "point": [0, 0, -0.4], "mu_c": 0.8}],
        "bodies": [{"shape": "sphere", "radius": 0.06, "center": [0.25, 0, -0.2], "density": 200.0}],
        **more,
    }


def same(a, b):
    assert a.keys() == b.keys()
    for name, values in a.items():
        np.testing.assert_array_equal(values, b[name], err_msg=name)


def test_bits_of_threads_and_of_resumes():
    """With heat, sleep, a body, emitters and a sink: the same bits on 1 to 3 threads, and after a resume."""
    found = []
    for threads in (1, 2, 3):
        sim = neve.Simulation(scene_from(scene_of_all()), threads=threads)
        for _ in range(6):
            sim.advance(0.04)
        found.append(sim.arrays())
    assert found[0]["flow_books"][:, 0].min() > 0
    assert sim.diagnostics().asleep > 0
    assert sim.diagnostics().water > 0
    same(found[0], found[1])
    same(found[0], found[2])
    stopped = neve.Simulation(scene_from(scene_of_all()), threads=1)
    for frame in range(6):
        if frame in (1, 4):
            stopped = neve.Simulation.restore(stopped.scene, stopped.arrays(), threads=2)
        stopped.advance(0.04)
    same(found[0], stopped.arrays())


def test_snow_that_slept_falls_into_a_hole():
    """A sink takes the lower half of a layer that sleeps: the upper half wakes and falls to the ground."""
    layer = {"shape": "box", "size": [0.4, 0.4, 0.2], "center": [0, 0, 0.1]}
    hole = {"shape": "box", "size": [1, 1, 0.1], "center": [0, 0, 0.05], "start": 1.0, "end": 1.05}
    sim = world(
        gravity=9.81, emitters=(), sources=[layer], sinks=[hole], numerics=SLEEPY,
        colliders=[{"shape": "plane", "mu_c": 0.8}], snow={"E0": 1e5, "theta_s": 0.02},
    )  # fmt: skip
    settle(sim, 0.95)
    high = float(np.asarray(sim.state.x)[:, 2].mean())
    sim.advance(0.35)
    assert sim.diagnostics().removed_mass > 0
    assert float(np.asarray(sim.state.x)[:, 2].min()) < 0.03
    assert float(np.asarray(sim.state.x)[:, 2].mean()) < high - 0.03


def test_births_wake_what_they_lie_in():
    """Snow that is born in a layer that sleeps wakes it there, and not at its other end."""
    layer = {"shape": "box", "size": [1.2, 0.2, 0.1], "center": [0, 0, 0.05]}
    late = {**NOZZLE, "center": [-0.5, 0, 0.08], "size": [0.1, 0.1, 0.02], "velocity": [0, 0, -0.5]}
    late["start"] = 1.0
    sim = world(
        gravity=9.81, emitters=(late,), sources=[layer], numerics=SLEEPY,
        colliders=[{"shape": "plane", "mu_c": 0.8}], snow={"E0": 1e5, "theta_s": 0.02},
    )  # fmt: skip
    settle(sim, 0.98)
    sim.advance(0.06)
    x, sleeps = np.asarray(sim.state.x), np.isinf(np.asarray(sim.state.rest)[:, 0])
    mouth = (np.abs(x[:, :2] - [-0.5, 0]) < 0.04).all(axis=1) & (np.abs(x[:, 2] - 0.08) < 0.02)
    assert mouth.sum() > 10
    assert not sleeps[mouth].any()
    assert sleeps[x[:, 0] > 0.2].mean() > 0.8


def test_numbers_are_never_given_twice():
    """After the last particles are taken out, new ones go on counting; each knows its emitter."""
    short, late = {**NOZZLE, "end": 0.05}, {**NOZZLE, "start": 0.5}
    sink = {"shape": "box", "center": [0.6, 0, 0], "size": [1.0, 1, 1], "start": 0.2, "end": 0.4}
    sim = world(emitters=[short, late], sinks=[sink])
    assert sim.count == 0
    assert sim.radius == pytest.approx(radius_at_birth(0.025**3))
    sim.advance(0.3)
    assert sim.count == 0
    assert sim.diagnostics().removed_mass == pytest.approx(sim.diagnostics().emitted_mass, rel=1e-12)
    went = round(sim.diagnostics().removed_mass / (400 * 0.025**3))
    sim = neve.Simulation.restore(sim.scene, sim.arrays())
    sim.advance(0.3)
    ids = np.asarray(sim.state.id)
    assert ids.min() == went
    assert set(np.asarray(sim.columns()["source"]()).tolist()) == {1}


def test_snow_can_be_thrown_in_and_the_scene_changed():
    """A ball thrown into an open world has its own number; emitters stay, may change and cannot go."""
    sim = world(gravity=9.81)
    sim.advance(0.05)
    before = sim.count
    sim.add(Source.of("sphere", radius=0.2, center=(3.0, 0.0, 0.0)))
    balls = sim.count - before
    sim.advance(0.05)
    whose = np.asarray(sim.columns()["source"]())
    assert (whose == 0).sum() == balls
    assert (whose == 1).sum() == sim.count - balls
    assert len(set(np.asarray(sim.state.id).tolist())) == sim.count
    slower = sim.scene.emitters[0].model_copy(update={"velocity": (1.0, 0.0, 0.0)})
    sim.change(sim.scene.model_copy(update={"emitters": (slower,)}))
    came = sim.diagnostics().emitted_mass
    sim.advance(0.1)
    assert sim.diagnostics().emitted_mass - came == pytest.approx(0.1 * 16.0, rel=0.2)
    with pytest.raises(SceneError, match="emitters cannot go while a run goes on"):
        sim.change(sim.scene.model_copy(update={"emitters": ()}))


def test_a_view_of_old_particles_stays_as_it_was():
    """An array that was handed out keeps its rows and its memory when more come and some go."""
    sim = world(sinks=[{"shape": "box", "center": [0.3, 0, 0], "size": [0.1, 1, 1]}])
    sim.advance(0.02)
    x, first = sim.state.x, sim.state
    while sim.state is first:
        sim.advance(0.005)
    copy = np.array(x)
    sim.advance(0.2)
    np.testing.assert_array_equal(x, copy)


def test_snow_that_cannot_get_away_is_one_sentence():
    """Particles in one place have more neighbours than any snow: the run ends with what to do."""
    sim = world(emitters=(), sources=[{"shape": "box", "size": [0.5, 0.5, 0.5]}])
    assert sim.count > 4096
    sim.state.x[...] = 0.0
    with pytest.raises(Blowup, match=r"more than 4,096 others within .* give emitters room"):
        sim.advance(0.01)


@pytest.mark.parametrize("rows", [[1, 0], [0, 0], [2, 9]])
def test_rows_to_keep_rise(rows):
    """Rows out of order, twice or past the end are refused."""
    sim = world(emitters=(), sources=[{"shape": "box", "size": [0.05, 0.05, 0.05]}])
    with pytest.raises((ValueError, IndexError)):
        sim.state.with_particles(np.array(rows, np.uint32), 0)


def test_contacts_whose_rows_do_not_rise_are_refused():
    """What is remembered of pairs is listed by rising rows; a damaged checkpoint is refused."""
    sim = world(emitters=(), sources=[{"shape": "box", "size": [0.1, 0.1, 0.1]}])
    begin, row, memory = map(np.array, sim.state.contacts())
    assert begin[1] >= 2
    row[[0, 1]] = row[[1, 0]]
    with pytest.raises(ValueError, match="not those of these particles"):
        sim.state.set_contacts(sim.solver._near, begin, row, memory)
