"""Snow that comes and goes: rates, jets, belts and books have known answers."""

import math

import numpy as np
import pytest
from verification.scenes import wide

import neve
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from

G = 9.81
NOZZLE = {"shape": "box", "size": [0.1, 0.2, 0.2], "velocity": [2, 0, 0], "center": [0, 0, 0]}


def world(gravity=0.0, emitters=(NOZZLE,), **more):
    numerics = {"dx": 0.05, **more.pop("numerics", {})}
    tables = {"world": {"gravity": [0, 0, -gravity]}, "numerics": numerics, "emitters": [*emitters], **more}
    return neve.Simulation(scene_from(tables))


def book(sim):
    return sim.diagnostics()


@pytest.mark.parametrize(
    ("emitter", "rate"),
    [
        (NOZZLE, 400 * 0.04 * 2),
        ({**NOZZLE, "mass_rate": 5.0}, 5.0),
        ({**NOZZLE, "volume_rate": 0.02, "snow": {"rho0": 250.0}}, 5.0),
        ({**NOZZLE, "mass_rate": 20.0, "spread": 15, "sampling": None}, 20.0),
    ],
)
def test_mass_comes_at_the_rate(emitter, rate):
    """After any time the mass is rate times time, but for the layer that is coming out: exact at its end.

    A layer has the mass of the section times a spacing; float32 masses add up to 1e-6.
    """
    emitter = {key: value for key, value in emitter.items() if value is not None}
    sim = world(emitters=[{**emitter, "start": 0.01}])
    layer = emitter.get("snow", {"rho0": 400.0})["rho0"] * 0.04 * 0.025
    for steps in (1, 2):
        sim.advance(steps * layer / rate + (0.01 if sim.time == 0 else 0.0))
        assert book(sim).mass == pytest.approx(rate * (sim.time - 0.01), rel=2e-6)
    sim.advance(0.4 * layer / rate)
    assert abs(book(sim).mass - rate * (sim.time - 0.01)) <= 0.5 * layer


def test_rate_does_not_depend_on_the_step():
    """A step of 10 ms, 80 % of a spacing, brings the same particles as short ones, of the same numbers."""
    ids = {}
    for dt in (2e-4, 1e-2):
        sim = world(numerics={"dt": dt, "precision": "float64"}, snow={"E0": 1000.0})
        sim.advance(0.1)
        c = wide(sim)
        ids[dt] = (sim.count, c["x"])
    (few, x), (many, y) = ids[2e-4], ids[1e-2]
    assert few == many
    np.testing.assert_allclose(x, y, atol=1e-9)


def test_a_jet_keeps_section_and_spacing():
    """Without gravity a jet is a moving block: every particle flies straight on, free of stress.

    x - v t is what left the section at t = 0; 1e-9 in float64, stress 1e-6 of Young's modulus.
    """
    sim = world(numerics={"precision": "float64"})
    sim.advance(0.25)
    c = wide(sim)
    assert sim.count == 20 * 8 * 8
    assert np.abs(c["x"][:, 1:]).max() <= 0.1
    np.testing.assert_allclose(c["v"], np.tile([2.0, 0, 0], (sim.count, 1)), atol=1e-9)
    assert np.abs(np.asarray(sim.state.tau)).max() < 1e-6 * 1.4e5
    histogram = np.histogram(c["x"][:, 0], 20, (0, 0.5))[0]
    np.testing.assert_array_equal(histogram, 64)


def test_a_falling_jet_is_ballistic():
    """Of a jet under gravity the mean place and velocity are those of free fall, whatever acts inside it.

    Particles have been under way for times spread evenly over t: mean of v tau + g tau^2 / 2 is v t / 2 + g
    t^2 / 6; the layers' jitter leaves 0.3 of a spacing over the root of their number. The step by step fall
    adds g tau dt / 2, 1e-3 m at most.
    """
    sim = world(gravity=G, numerics={"precision": "float64"})
    t = 0.25
    sim.advance(t)
    c = wide(sim)
    assert c["x"].mean(axis=0) == pytest.approx([t, 0, -G * t * t / 6], abs=2e-3)
    assert c["v"].mean(axis=0) == pytest.approx([2.0, 0, -G * t / 2], abs=5e-3)
    momentum = np.array(book(sim).momentum)
    expected = 400 * 0.04 * 2 * t * np.array([2.0, 0, -G * t / 2])
    assert momentum == pytest.approx(expected, rel=2e-3, abs=1e-9)


def test_thin_snow_flies_alone():
    """Specks of a thin flow fly on a parabola, z = -g x^2 / (2 v^2): within half a cell, since some meet."""
    sim = world(gravity=G, emitters=[{**NOZZLE, "mass_rate": 0.5}], numerics={"precision": "float64"})
    sim.advance(0.3)
    c = wide(sim)
    fall = -G * (c["x"][:, 0] / 2) ** 2 / 2
    assert sim.count == pytest.approx(0.5 * 0.3 / (400 * 0.025**3), abs=12)
    assert np.abs(c["x"][:, 2] - fall).max() <= 0.1 + 0.025


def test_spread_flies_apart():
    """Directions of a thin spread flow fill the cone; none leaves it but by a step's rounding."""
    sim = world(emitters=[{**NOZZLE, "mass_rate": 0.3, "spread": 30}])
    sim.advance(0.3)
    v = wide(sim)["v"]
    angle = np.degrees(np.arccos(v[:, 0] / np.linalg.norm(v, axis=1)))
    assert 20 < angle.max() < 31


def test_a_belt_is_in_balance():
    """Snow laid on a belt at its own speed: what comes on leaves at its end, and the load is rate times time.

    The load is 400 kg/m3 x 0.04 m2 x 0.8 m; a layer, and what a sink holds between looks, is open.
    """
    belt = {"shape": "plane", "point": [0, 0, -0.1], "surface_velocity": [2, 0, 0], "mode": "sticky"}
    sink = {"shape": "box", "center": [1.3, 0, 0], "size": [1.0, 1, 1]}
    sim = world(emitters=[NOZZLE], colliders=[belt], sinks=[sink])
    sim.advance(0.6)
    for _ in range(4):
        sim.advance(0.05)
        now = book(sim)
        assert now.mass == pytest.approx(400 * 0.04 * 0.8, abs=1.0)
        assert now.emitted_mass == pytest.approx(32.0 * sim.time, abs=0.4)
        assert now.mass == pytest.approx(now.emitted_mass - now.removed_mass, rel=1e-12)
        assert now.removed_momentum[0] == pytest.approx(2.0 * now.removed_mass, rel=1e-3)
    assert wide(sim)["x"][:, 0].max() <= 0.8 + 1e-9


def test_books_close_with_snow_at_the_start():
    """Mass at the start plus what came less what went is what is there, to the rounding of sums in double."""
    ball = {"shape": "sphere", "radius": 0.2, "center": [1.0, 0, 0], "velocity": [0, 0, 3.0]}
    sink = {"shape": "box", "center": [1.2, 0, 0.6], "size": [0.4, 1, 0.4], "start": 0.05}
    sim = world(sources=[ball], sinks=[sink], gravity=0.0)
    start = book(sim).mass
    for _ in range(10):
        sim.advance(0.02)
        now = book(sim)
        assert now.mass == pytest.approx(start + now.emitted_mass - now.removed_mass, rel=1e-12)
    assert 0 < now.removed_mass < start
    gone = now.removed_mass
    assert now.removed_energy == pytest.approx(0.5 * gone * 9.0, rel=0.05)


def test_energy_of_what_comes_and_goes_is_no_growth(tmp_path):
    """The watch over energy counts what snow brings: a jet in free flight gains nothing."""
    sink = {"shape": "box", "center": [1.0, 0, -0.2], "size": [0.5, 2, 2]}
    sim = world(gravity=G, sinks=[sink], run={"duration": 0.6, "fps": 20, "film": False})
    sim.run(tmp_path / "run", quiet=True)
    from neve.io.log import read_log

    rows = read_log(tmp_path / "run/log.csv", "mpm", True)
    kinetic = max(float(row["kinetic"]) for row in rows)
    assert float(rows[-1]["removed_mass"]) > 0
    for row in rows[2:]:
        assert float(row["excess"]) <= 0.01 * kinetic


@pytest.mark.parametrize("threads", [1, 3])
def test_same_bits_on_any_threads(threads):
    """An emitter, a sink and a heap: all arrays are equal to the bit on 1, 2 and 3 threads."""
    found = []
    for count in (2, threads):
        heap = {"shape": "box", "size": [0.3, 0.3, 0.3], "center": [0.6, 0, -0.2]}
        tables = {
            "numerics": {"dx": 0.05},
            "sources": [heap],
            "emitters": [{**NOZZLE, "spread": 10, "mass_rate": 20.0}, {**NOZZLE, "center": [0, 0, 0.5]}],
            "sinks": [{"shape": "sphere", "center": [0.45, 0, 0], "radius": 0.1}],
            "colliders": [{"shape": "plane", "point": [0, 0, -0.4]}],
        }
        sim = neve.Simulation(scene_from(tables), threads=count)
        sim.advance(0.2)
        found.append(sim.arrays())
    assert found[0]["flow_books"][1, 0] > 0
    for name, values in found[0].items():
        np.testing.assert_array_equal(values, found[1][name], err_msg=name)


def test_numbers_are_never_given_twice():
    """After the last particles are taken out, new ones go on counting; each knows its emitter."""
    short = {**NOZZLE, "end": 0.05}
    late = {**NOZZLE, "start": 0.5}
    sink = {"shape": "box", "center": [0.6, 0, 0], "size": [1.0, 1, 1], "start": 0.2, "end": 0.4}
    sim = world(emitters=[short, late], sinks=[sink])
    sim.advance(0.3)
    assert sim.count == 0
    sim.advance(0.3)
    ids = np.asarray(sim.state.id)
    assert len(ids)
    assert ids.min() == round(book(sim).removed_mass / (400 * 0.025**3))
    assert set(np.asarray(sim.columns()["source"]()).tolist()) == {1}


def test_snow_can_be_thrown_in_and_the_scene_changed():
    """A ball thrown into an open world has its own number; emitters stay, may change and cannot go."""
    sim = world(gravity=G)
    sim.advance(0.05)
    before = sim.count
    from neve.scene.schema.scene import Source

    sim.add(Source.of("sphere", radius=0.2, center=(3.0, 0.0, 0.0)))
    balls = sim.count - before
    sim.advance(0.05)
    whose = np.asarray(sim.columns()["source"]())
    assert (whose == 0).sum() == balls
    assert (whose == 1).sum() == sim.count - balls
    slower = sim.scene.emitters[0].model_copy(update={"velocity": (1.0, 0.0, 0.0)})
    sim.change(sim.scene.model_copy(update={"emitters": (slower,)}))
    came = book(sim).emitted_mass
    sim.advance(0.1)
    assert book(sim).emitted_mass - came == pytest.approx(0.1 * 16.0, rel=0.2)
    with pytest.raises(SceneError, match="emitters cannot go while a run goes on"):
        sim.change(sim.scene.model_copy(update={"emitters": ()}))


def test_a_view_of_old_particles_stays_as_it_was():
    """An array that was handed out keeps its rows and its memory when more come."""
    sim = world()
    sim.advance(0.02)
    x = sim.state.x
    count, copy = len(x), np.array(x)
    sim.advance(0.5)
    assert len(x) == count < sim.count
    assert np.isfinite(np.asarray(x)).all()
    assert copy.shape == x.shape


@pytest.mark.parametrize(
    ("numerics", "told"),
    [
        (
            {"method": "sph"},
            'emitters: numerics.method = "sph" adds and removes no snow; use "mpm" or "particles"',
        ),
        ({"device": "cuda"}, 'emitters: numerics.device = "cuda" adds and removes no snow; use "cpu"'),
    ],
)
def test_where_there_are_none_one_sentence_says_so(numerics, told):
    """Methods and devices without them refuse emitters and sinks."""
    with pytest.raises(SceneError) as error:
        world(numerics=numerics)
    assert told in str(error.value)


def test_too_many_to_come_are_refused_at_once():
    """What emitters would add without a sink counts before the first step."""
    with pytest.raises(SceneError, match=r"together would take .* more than|which needs|free"):
        world(numerics={"dx": 0.005}, run={"duration": 80000.0})


def test_the_device_auto_uses_the_processor():
    """Snow comes on the processor where "auto" may choose."""
    sim = world(numerics={"device": "auto"})
    sim.advance(0.02)
    assert sim.count > 0
    assert math.isclose(book(sim).mass, 32.0 * 0.02, rel_tol=0.4)
