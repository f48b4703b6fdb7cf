"""What changes in time: gravity, snow and emitters follow their keyframes, exactly and with exact resume."""

import numpy as np
import pytest
from verification.scenes import wide

import neve
from neve.run import run_scene
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.viewer.players.snapshot import present

BALL = {"shape": "sphere", "radius": 0.2, "center": [0, 0, 0]}
NOZZLE = {"shape": "box", "size": [0.1, 0.2, 0.2], "velocity": [2, 0, 0], "center": [0, 0, 0]}


def of(**tables):
    tables["numerics"] = {"dx": 0.1, "precision": "float64", **tables.get("numerics", {})}
    return scene_from({"sources": [BALL], **tables})


@pytest.mark.parametrize("method", ["mpm", "particles"])
def test_a_lump_falls_as_gravity_changes(method):
    """Between two keyframes gravity is g s^2 (3 - 2 s): the velocity is its integral, g T / 2 after T.

    Steps of dt take gravity at their start, which is off by g dt / 2 in all.
    """
    keys = [{"t": 0.0, "gravity": [0, 0, 0]}, {"t": 0.2, "gravity": [3.0, 0, -9.81]}]
    sim = neve.Simulation(of(world={"keyframes": keys}, numerics={"dt": 1e-3, "method": method}))
    sim.advance(0.2)
    v = wide(sim)["v"].mean(axis=0) if method == "mpm" else np.asarray(sim.state.v).mean(axis=0)
    assert v == pytest.approx([0.3, 0, -0.981], abs=6e-3)
    sim.advance(0.1)
    now = wide(sim)["v"].mean(axis=0) if method == "mpm" else np.asarray(sim.state.v).mean(axis=0)
    assert now - v == pytest.approx([0.3, 0, -0.981], abs=1e-9)


def test_bodies_fall_as_gravity_changes():
    """A body without snow near it has the same velocity as the formula: g T / 2."""
    keys = [{"t": 0.0, "gravity": [0, 0, 0]}, {"t": 0.2}]
    body = {"shape": "sphere", "radius": 0.3, "center": [5, 0, 0], "density": 500.0}
    sim = neve.Simulation(of(world={"keyframes": keys}, bodies=[body], numerics={"dt": 1e-3}))
    sim.advance(0.2)
    assert sim.solids()[0][1].velocity[2] == pytest.approx(-0.981, abs=6e-3)


def test_snow_stiffens():
    """Young's modulus rises fourfold: stretched snow stores and pulls four times as much, in both rows alike.

    A source with an E0 of its own keeps it.
    """
    stiff = {**BALL, "center": [2, 0, 0], "snow": {"E0": 5e4}}
    keys = [{"t": 0.0, "E0": 1e5}, {"t": 0.1, "E0": 4e5}]
    scene = of(sources=[BALL, stiff], snow_keyframes=keys, world={"gravity": [0, 0, 0]})
    assert pytest.approx(2.5e5) == scene.snow_at(0.05).E0
    sim = neve.Simulation(scene)
    stress = {}
    for t in (0.0, 0.2):
        if t:
            sim.advance(t - sim.time)
        sim.state.F_E[...] = np.diag([1.001, 1.0, 1.0])
        sim.solver.begin(sim.steps, sim.time)
        material = np.asarray(sim.state.material)
        stress[t] = [np.asarray(sim.state.tau)[material == row, 0].mean() for row in (0, 1)]
    assert stress[0.2][0] == pytest.approx(4 * stress[0.0][0], rel=1e-3)
    assert stress[0.2][1] == pytest.approx(stress[0.0][1], rel=1e-3)


def test_mass_follows_a_rate_that_changes():
    """Mass is the integral of the rate: 4 s^2 (3 - 2 s) from 0 to 8 kg/s in 0.4 s, half of 8 x 0.4 kg."""
    keys = [{"t": 0.0, "mass_rate": 0.0}, {"t": 0.4, "mass_rate": 8.0}]
    sim = neve.Simulation(of(sources=[], emitters=[{**NOZZLE, "mass_rate": 8.0, "keyframes": keys}]))
    for _ in range(4):
        sim.advance(0.1)
        s = sim.time / 0.4
        expected = 8.0 * 0.4 * (s**3 - 0.5 * s**4)
        assert sim.diagnostics().mass == pytest.approx(expected, abs=400 * 0.04 * 0.05)
    assert sim.diagnostics().emitted_mass == pytest.approx(1.6, abs=0.4)


def test_a_nozzle_that_turns_up():
    """Full flow whose velocity grows from 1 to 2 m/s: the mass is section times way, none too dense."""
    keys = [{"t": 0.0, "velocity": [1.0, 0, 0]}, {"t": 0.3, "velocity": [2.0, 0, 0]}]
    sim = neve.Simulation(
        of(sources=[], emitters=[{**NOZZLE, "keyframes": keys}], world={"gravity": [0, 0, 0]})
    )
    sim.advance(0.3)
    assert sim.diagnostics().mass == pytest.approx(400 * 0.04 * 0.45, abs=400 * 0.04 * 0.05)
    assert wide(sim)["v"][:, 0].max() == pytest.approx(2.0, abs=0.15)


def test_a_nozzle_that_comes_to_rest():
    """A spread flow that stops brings the way of its velocity, 2 m/s x 0.1 s / 2 and no more, and no NaN."""
    keys = [{"t": 0.0}, {"t": 0.1, "velocity": [0, 0, 0]}]
    nozzle = {**NOZZLE, "spread": 10.0, "keyframes": keys}
    sim = neve.Simulation(of(sources=[], emitters=[nozzle], world={"gravity": [0, 0, 0]}))
    sim.advance(0.15)
    count = sim.count
    assert sim.diagnostics().mass == pytest.approx(400 * 0.04 * 0.1, abs=400 * 0.04 * 0.05)
    sim.advance(0.05)
    assert sim.count == count
    assert np.isfinite(wide(sim)["v"]).all()


def test_resume_is_exact(tmp_path):
    """Gravity, snow and an emitter that change: stopped in the middle and resumed, the bits are the same."""
    tables = {
        "numerics": {"dx": 0.1},
        "world": {"keyframes": [{"t": 0.0, "gravity": [0, 0, -2]}, {"t": 0.3, "gravity": [2, 0, -9]}]},
        "snow_keyframes": [{"t": 0.1, "E0": 1e5, "xi": 5.0}, {"t": 0.25, "E0": 2e5, "xi": 12.0}],
        "emitters": [{**NOZZLE, "mass_rate": 9.0, "keyframes": [{"t": 0.1}, {"t": 0.2, "mass_rate": 2.0}]}],
        "colliders": [{"shape": "plane", "point": [0, 0, -0.3]}],
        "run": {"duration": 0.3, "fps": 20, "film": False},
    }
    scene = scene_from(tables)
    run_scene(scene, tmp_path / "whole", quiet=True, threads=1)
    run_scene(scene, tmp_path / "parts", frames=3, quiet=True)
    run_scene(scene, tmp_path / "parts", resume=True, quiet=True)
    for file in (tmp_path / "whole/frames").iterdir():
        assert file.read_bytes() == (tmp_path / "parts/frames" / file.name).read_bytes()
    now = present(scene, 0.2)
    assert now["world.gravity"][0] == pytest.approx(2 * (4 / 9) * (3 - 4 / 3))
    assert now["snow.E0"][0] > 1e5
    assert now["emitters.0.mass_rate"] == [2.0]


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ({"world": {"keyframes": [{"t": 1.0}, {"t": 1.0}]}}, "world.keyframes.1.t"),
        ({"snow_keyframes": [{"t": 1.0}, {"t": 0.5}]}, "snow_keyframes.1.t"),
        ({"snow_keyframes": [{"rho0": 300.0}]}, "snow_keyframes.0.rho0"),
        ({"snow_keyframes": [{"law": "cam_clay"}]}, "snow_keyframes.0.law"),
        ({"snow_keyframes": [{"p0": 1e3}]}, "snow_keyframes.0.p0"),
        ({"snow_keyframes": [{"nu": 0.9}]}, "snow_keyframes.0.nu"),
        ({"emitters": [{**NOZZLE, "keyframes": [{"mass_rate": 1.0}]}]}, "emitters.0.keyframes.0.mass_rate"),
        ({"emitters": [{**NOZZLE, "keyframes": [{"velocity": [-1, 0, 0]}]}]}, "keyframes.0.velocity"),
        (
            {"emitters": [{**NOZZLE, "mass_rate": 9.0, "keyframes": [{"t": 1.0, "mass_rate": 99.0}]}]},
            "emitters.0.keyframes.0: mass_rate = 99 must be at most 32",
        ),
        ({"numerics": {"method": "particles"}, "snow_keyframes": [{"E0": 1e5}]}, "snow_keyframes: numerics"),
    ],
)
def test_what_cannot_change_is_one_sentence(tables, told):
    """Keyframes of what is no parameter, cannot change live, or makes no sense, are refused by their key."""
    with pytest.raises(SceneError) as error:
        neve.Simulation(of(**tables))
    assert told in str(error.value)
    assert "\n" not in str(error.value)
