"""Water among smoothed particles: a column, a dam break, a block that floats, momentum, files, refusals."""

import numpy as np
import pytest
from verification.sph.common import smoothed

from neve.io.frames import read_frame
from neve.run import run_scene
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.validate.scenes import plane

G = 9.81
SPACING = 0.05
FLOOR = plane((0, 0, 0), (0, 0, 1), mu_c=0.0)


def tank(x, y):
    """Smooth walls around the middle, x wide and y deep, and a floor."""
    sides = [((-x / 2, 0, 0), (1, 0, 0)), ((x / 2, 0, 0), (-1, 0, 0))]
    sides += [((0, -y / 2, 0), (0, 1, 0)), ((0, y / 2, 0), (0, -1, 0))]
    return [plane(point, normal, mu_c=0.0) for point, normal in sides] + [FLOOR]


def water(center, size, **more):
    """A box of water."""
    return {"shape": "box", "center": center, "size": size, "phase": "water", **more}


def basin(sources, width=0.4, snow=None, **numerics):
    """Water and snow in a smooth square duct with a floor."""
    return smoothed(sources, tank(width, width), (0.0, 0.0, -G), snow, **({"dt_max": 5e-3} | numerics))


def is_water(sim):
    return np.asarray(sim.columns()["phase"]()) == 1.0


def overfill(sim):
    """How much more of its kernel is filled than was at birth, of water alone."""
    return np.asarray(sim.state.fill) - np.asarray(sim.state.rho_birth) / 1000.0


def test_a_column_of_water_is_hydrostatic():
    """At rest the floor bears the weight, and the pressure falls with height by rho g and a twentieth.

    Particles at the walls carry a little less than their share, those inside more.
    """
    sim = basin([water((0, 0, 0.25), (0.4, 0.4, 0.5))])
    sim.advance(0.8)
    weight = sim.diagnostics().mass * G
    force, slope = 0.0, []
    for _ in range(10):
        sim.advance(0.02)
        force -= sim.stats.exchanged[-1, 2] / 0.2
        z, p = np.asarray(sim.state.x)[:, 2], np.asarray(sim.state.p)
        inside = (z > 0.08) & (z < 0.42)
        slope.append(np.polyfit(z[inside], p[inside], 1)[0])
    assert force == pytest.approx(weight, rel=0.02)
    assert np.mean(slope) == pytest.approx(-1050.0 * G, rel=0.03)
    assert np.asarray(sim.state.x)[:, 2].max() + SPACING / 2 == pytest.approx(0.5, abs=SPACING / 2)
    assert sim.diagnostics().kinetic < 2e-4 * weight * 0.25
    assert not np.asarray(sim.state.F_E - np.eye(3)).any()  # nothing keeps how it was deformed


def test_a_dam_break_keeps_its_volume():
    """A column runs out over the floor of a tank and comes to lie level: none of it is pressed together.

    Kernels are filled by no more than 0.5 % over what they were at birth in the mean, where the wave hits the
    wall by 10 %; in the end by 0.5 % at most, and the height is that of the volume over the area, to a
    twentieth of a spacing.
    """
    sim = smoothed(
        [water((-0.25, 0, 0.25), (0.3, 0.2, 0.5))],
        tank(0.8, 0.2),
        (0.0, 0.0, -G),
        dt_max=2.5e-3,  # the gradient of what walls fill is found at the start of a step
        precision="float32",
    )
    before = sim.diagnostics()
    start = before.kinetic + before.potential
    front, most, mean = -0.1, 0.0, 0.0
    for _ in range(16):
        sim.advance(0.1)
        over = np.maximum(overfill(sim), 0.0)
        most, mean = max(most, float(over.max())), max(mean, float(over.mean()))
        front = max(front, float(np.asarray(sim.state.x)[:, 0].max()))
        now = sim.diagnostics()
        assert now.kinetic + now.potential < start + 1e-3 * abs(start)
        if sim.time < 0.2:  # not even without friction is the tip of a dry dam break faster (Ritter 1892)
            assert front <= -0.1 + 2.0 * np.sqrt(G * 0.5) * sim.time
    assert front > 0.35
    assert most < 0.1
    assert mean < 0.005
    assert overfill(sim).max() < 0.005
    x = np.asarray(sim.state.x)
    depth = 0.3 * 0.2 * 0.5 / (0.8 * 0.2)
    assert 2.0 * x[:, 2].mean() == pytest.approx(depth, abs=SPACING / 20)


@pytest.mark.parametrize(("rho", "start"), [(300.0, 0.05), (600.0, 0.25)])
def test_a_block_of_snow_floats(rho, start):
    """The share of a block under water is rho_snow / rho_water, to half a particle spacing.

    start [m]: how deep it is at the start, too little or too much. With V that of the water, A and a the
    areas of basin and block, water to the depth d of the block stands at (V + a d) / A over the floor.
    """
    side, depth, width = 0.3, 0.35, 0.5
    sim = basin(
        [
            {"shape": "box", "center": (0, 0, depth - start + side / 2), "size": (side, side, side)},
            water((0, 0, depth / 2), (width, width, depth), overlap="cut"),
        ],
        width,
        {"rho0": rho, "E0": 2e5, "plasticity": "none"},
        sampling="regular",
        precision="float32",
    )
    shares = []
    sim.advance(0.6)
    for _ in range(4):
        sim.advance(0.1)
        x, wet = np.asarray(sim.state.x), is_water(sim)
        bottom = x[~wet, 2].min() - SPACING / 2
        level = np.asarray(sim.state.V0)[wet].sum() / width**2
        shares.append((level - bottom) / (1.0 - side**2 / width**2) / side)
    assert np.mean(shares) == pytest.approx(rho / 1000.0, abs=0.5 * SPACING / side)


def test_snow_and_water_exchange_momentum():
    """A ball of snow in a ball of water, without gravity: what one gains the other loses, to rounding."""
    sim = smoothed(
        [
            {"shape": "sphere", "radius": 0.15, "center": (-0.3, 0, 0), "velocity": (3, 0, 0)},
            {
                "shape": "sphere",
                "radius": 0.15,
                "center": (0.05, 0.05, 0),
                "velocity": (-1, 0, 0),
                "phase": "water",
            },
        ]
    )
    wet = is_water(sim)
    m, v = np.asarray(sim.state.m), np.asarray(sim.state.v)
    before = sim.diagnostics()
    apart = (m[wet] @ v[wet], m[~wet] @ v[~wet])
    sim.advance(0.2)
    wet, m, v = is_water(sim), np.asarray(sim.state.m), np.asarray(sim.state.v)
    after = sim.diagnostics()
    scale = before.mass * 3.0
    np.testing.assert_allclose(after.momentum, before.momentum, atol=1e-12 * scale)
    gained = m[wet] @ v[wet] - apart[0]
    assert np.linalg.norm(gained) > 0.1 * scale * 0.1
    np.testing.assert_allclose(gained, apart[1] - m[~wet] @ v[~wet], atol=1e-12 * scale)
    assert after.kinetic + after.elastic < before.kinetic


def test_viscous_fluid_flows_slower():
    """A column of a fluid of 200 Pa s spreads less than one of water in the same time."""

    def spread(viscosity):
        scene = {
            "numerics": {"method": "sph", "dx": SPACING, "particles_per_cell": 1, "dt_max": 5e-3},
            "water": {"viscosity": viscosity},
            "sources": [water((0, 0, 0.2), (0.2, 0.2, 0.4))],
            "colliders": [FLOOR],
        }
        sim = Simulation(scene_from(scene), threads=1)
        sim.advance(0.3)
        x = np.asarray(sim.state.x)
        return float(np.sqrt(np.mean(x[:, 0] ** 2 + x[:, 1] ** 2)))

    thin, thick = spread(1e-3), spread(200.0)
    assert thick < 0.6 * thin
    assert thick >= 0.99 * np.sqrt(2 * 0.2**2 / 12)


def falling(threads=1):
    """A ball of snow that falls into a basin, in float32."""
    ball = {"shape": "sphere", "radius": 0.12, "center": (0.02, 0, 0.35), "velocity": (0, 0, -3)}
    return smoothed(
        [water((0, 0, 0.1), (0.4, 0.4, 0.2)), ball],
        tank(0.4, 0.4),
        (0.0, 0.0, -G),
        threads=threads,
        precision="float32",
        dt_max=5e-3,
    )


def same_bits(a, b):
    one, other = a.arrays(), b.arrays()
    assert one.keys() == other.keys()
    for name in one:
        np.testing.assert_array_equal(np.asarray(one[name]), np.asarray(other[name]), err_msg=name)


def test_threads_and_a_resume_give_the_same_bits():
    """Through the impact: pressures are kept, so that the solves go on from the same numbers."""
    sims = [falling(threads) for threads in (1, 2, 3)]
    for sim in sims:
        sim.advance(0.05)
        sim.advance(0.05)
    same_bits(sims[0], sims[1])
    same_bits(sims[0], sims[2])
    half = falling()
    half.advance(0.05)
    assert np.asarray(half.state.p_last).any()
    again = Simulation.restore(half.scene, half.arrays(), threads=1)
    again.advance(0.05)
    same_bits(sims[0], again)


def test_frames_say_what_is_water(tmp_path):
    """Their `phase` is 1 of water, 0 of snow; the density is that of each."""
    scene = scene_from(
        {
            "numerics": {"method": "sph", "dx": 0.1, "particles_per_cell": 1},
            "sources": [
                {"shape": "sphere", "radius": 0.2, "center": (0, 0, 0.8)},
                water((0, 0, 0.2), (0.6, 0.6, 0.4)),
            ],
            "colliders": [{"shape": "plane"}],
            "run": {"duration": 0.05, "fps": 20, "film": False, "fields": ["density"]},
        }
    )
    run_scene(scene, tmp_path / "run", quiet=True)
    frame = read_frame(tmp_path / "run" / "frames", 1)
    wet = frame.more["phase"] == 1.0
    assert set(np.unique(frame.more["phase"])) == {0.0, 1.0}
    np.testing.assert_array_equal(wet, frame.more["source"] == 1)
    np.testing.assert_allclose(frame.more["density"][wet], 1000.0, rtol=1e-6)
    assert (frame.more["density"][~wet] < 600.0).all()


@pytest.mark.parametrize("density", [5.0, 13_600.0])
def test_any_fluid_is_legal(density):
    """The bounds of a law of snow are not those of a fluid: mercury flows, and what is lighter than snow."""
    scene = scene_from(
        {
            "numerics": {"method": "sph", "dx": 0.1, "particles_per_cell": 1},
            "water": {"density": density},
            "sources": [water((0, 0, 0.2), (0.4, 0.4, 0.4))],
        }
    )
    assert Simulation(scene, threads=1).diagnostics().mass == pytest.approx(density * 0.4**3)


@pytest.mark.parametrize("method", ["mpm", "particles"])
def test_other_methods_refuse_water(method):
    """In one sentence, at the start and of snow that is added."""
    told = f'phase = "water": numerics.method = "{method}" knows snow alone; use "sph"'
    numerics = {"method": method, "dx": 0.1}
    wet, dry = (
        water((0, 0, 1), (0.4, 0.4, 0.4)),
        {"shape": "box", "center": (0, 0, 1), "size": (0.4, 0.4, 0.4)},
    )
    with pytest.raises(SceneError, match=f"sources.0.{told}"):
        Simulation(scene_from({"numerics": numerics, "sources": [wet]}))
    sim = Simulation(scene_from({"numerics": numerics, "sources": [dry]}))
    with pytest.raises(SceneError, match=f"sources.1.{told}"):
        sim.add(scene_from({"sources": [wet]}).sources[0])


def test_what_water_has_not():
    """Snow's own keys are one sentence."""
    with pytest.raises(SceneError, match=r"sources\.0\.variation.* is of snow"):
        scene_from({"sources": [water((0, 0, 1), (1, 1, 1), variation={"stiffness": 0.5})]})
