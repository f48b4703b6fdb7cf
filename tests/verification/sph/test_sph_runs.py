"""Smoothed particles as a solver: bits of threads and resumes, refused steps, the log, changes, refusals."""

from types import SimpleNamespace

import numpy as np
import pytest
from verification.sph.common import smoothed

from neve.io.log import read_log
from neve.run import run_scene
from neve.scene.errors import SceneError
from neve.scene.reading.load import scene_from
from neve.scene.schema.scene import Snow
from neve.simulation import Simulation
from neve.solver import Blowup
from neve.sph.constants import LARGEST, TOLERANCE, law_constants
from neve.sph.pace import Pace
from neve.sph.step import Attempt

BALL = {"shape": "sphere", "radius": 0.25, "center": (0, 0, 0.5), "velocity": (2, 0, -3)}
TURNING = {"shape": "box", "center": (0.5, 0, 0.1), "size": (0.1, 0.6, 0.3), "spin": (0, 0, 2)}
BODY = {"shape": "box", "center": (-0.3, 0, 0.1), "size": (0.15, 0.15, 0.15), "density": 300.0}
WORLD = ({"shape": "plane"}, TURNING)


def fall(threads=1, **numerics):
    """A ball that falls on the ground between a wall that turns and a body, in float32."""
    return smoothed(
        [BALL], WORLD, (0.0, 0.0, -9.81), threads=threads, bodies=[BODY], precision="float32", **numerics
    )


def same_bits(a, b):
    """Whether two simulations have the same arrays."""
    one, other = a.arrays(), b.arrays()
    assert one.keys() == other.keys()
    for name in one:
        np.testing.assert_array_equal(np.asarray(one[name]), np.asarray(other[name]), err_msg=name)


def test_threads_give_the_same_bits():
    """One, two and three threads, through an impact: the order of sums does not depend on them."""
    sims = [fall(threads) for threads in (1, 2, 3)]
    for sim in sims:
        sim.advance(0.15)
    same_bits(sims[0], sims[1])
    same_bits(sims[0], sims[2])


def test_a_resume_goes_on_with_the_same_bits():
    """Boundary particles are sampled anew, around where the snow is then: none that counts is another."""
    whole = fall()
    for _ in range(3):
        whole.advance(0.05)
    half = fall()
    half.advance(0.05)
    again = Simulation.restore(half.scene, half.arrays(), threads=1)
    for _ in range(2):
        again.advance(0.05)
    same_bits(whole, again)


def test_what_is_restored_is_as_it_was():
    """Densities and energies are those of where snow and solids are now, before and after a resume.

    The wall has turned since t = 0, and snow has moved in the last step: with either, J_P would be another.
    """
    sim = fall()
    sim.advance(0.12)
    again = Simulation.restore(sim.scene, sim.arrays(), threads=1)
    assert np.ptp(np.asarray(sim.state.J_P)) > 0.01
    same_bits(sim, again)
    now, then = again.diagnostics(), sim.diagnostics()
    assert (now.elastic, now.kinetic) == (then.elastic, then.kinetic)


def test_a_pace_learns_from_what_failed():
    """Solves that fail beyond 1 ms: of 2000 steps one in 64 fails at last, and most are near that."""

    def run(iterations):
        pace, dt, failed, steps = Pace(), 4e-3, 0, []
        while len(steps) < 2000:
            dt = min(4e-3, pace.longest)
            while dt > 1e-3:
                pace.failed(dt)
                dt, failed = 0.5 * dt, failed + 1
            report = SimpleNamespace(iterations=iterations(dt))
            steps.append(dt)
            pace.succeeded(Attempt("", report, report), dt == pace.longest)
        return failed, np.mean(steps)

    failed, mean = run(lambda dt: 1)
    assert failed < 60
    assert mean > 0.8e-3
    # whoever needs 120 of 150 iterations does not try a longer step at all
    failed, _ = run(lambda dt: int(1.3e5 * dt))
    assert failed <= 3
    saved = Pace()
    saved.failed(1e-3)
    assert Pace(saved.save()).longest == 0.5e-3


def test_a_step_too_short_is_an_error():
    """More than a thousand million steps for what is asked are refused, with what bounds them."""
    sim = smoothed([BALL], WORLD, dt=1e-9)
    with pytest.raises(Blowup, match=r"after step 0 the time step is bound to 1e-09 s \(fixed\)"):
        sim.advance(10.0)


def test_a_solve_that_fails_is_tried_shorter(monkeypatch):
    """With few iterations no long step of stiff snow succeeds: it is halved until one does."""
    monkeypatch.setattr("neve.sph.step.MOST_PRESSURE", 12)
    monkeypatch.setattr("neve.sph.solver.SWING", np.inf)  # whatever pressed snow allows
    sim = smoothed([BALL], WORLD, (0.0, 0.0, -9.81), {"E0": 1e7})
    sim.advance(0.12)
    assert sim.stats.rejected > 0
    assert sim.stats.bound == "solve"
    solves = sim.diagnostics().solves
    assert solves.pressure_residual <= TOLERANCE
    assert solves.pressure_largest <= LARGEST
    assert solves.shear_residual <= TOLERANCE


def test_no_step_at_all_is_an_error(monkeypatch):
    """If no step succeeds the run ends with one sentence; what was refused has moved nothing."""
    monkeypatch.setattr("neve.sph.step.MOST_PRESSURE", 0)
    monkeypatch.setattr("neve.sph.step.TOLERANCE", 0.0)
    sim = fall()
    sim.state.v[...] *= 1.0 - 4.0 * (np.asarray(sim.state.x) - [0.0, 0.0, 0.5])
    names = ("x", "v", "F_E", "rho_birth", "id")
    before = {name: np.array(getattr(sim.state, name)) for name in names}
    with pytest.raises(Blowup, match=r"no step succeeds, down to .* pressure has not converged after 0 iter"):
        sim.advance(0.1)
    for name in names:
        np.testing.assert_array_equal(before[name], getattr(sim.state, name))


def test_a_particle_without_a_place_is_one_sentence():
    """A NaN among the positions ends the run, at the next beginning."""
    sim = fall()
    sim.state.x[3, 0] = np.nan
    with pytest.raises(Blowup, match="a particle has no finite place"):
        sim.advance(0.01)


def test_a_run_folder_has_the_solves(tmp_path):
    """Frames, log and checkpoint come by the seam; the log has iterations and residuals of each frame."""
    scene = scene_from(
        {
            "numerics": {"method": "sph", "dx": 0.1},
            "sources": [dict(BALL, radius=0.2)],
            "colliders": [{"shape": "plane"}],
            "run": {"duration": 0.1, "fps": 50, "film": False},
        }
    )
    run_scene(scene, tmp_path / "run", quiet=True)
    rows = read_log(tmp_path / "run" / "log.csv", "sph", scene.is_open)
    assert len(rows) == 6
    assert float(rows[-1]["pressure_iterations"]) >= 2
    for row in rows[1:]:
        assert 0 < float(row["pressure_residual"]) <= TOLERANCE
        assert 0 < float(row["pressure_largest"]) <= LARGEST
        assert float(row["shear_residual"]) <= TOLERANCE
    assert "stress" in {row["bound"] for row in rows}  # snow that rests on the ground is pressed
    assert {row["bound"] for row in rows[1:]} <= {"dt_max", "speed", "strain", "stress", "body", "solve"}


def test_snow_is_added_and_the_scene_changed():
    """A second ball falls on the first; ids go on; a wall that goes is gone."""
    sim = fall()
    sim.advance(0.05)
    first = sim.count
    sim.add(scene_from({"sources": [dict(BALL, center=(0, 0, 1.2))]}).sources[0])
    assert sim.count > first
    assert sorted(sim.state.id) == list(range(sim.count))
    assert (np.asarray(sim.state.rho_birth) > 0).all()
    sim.advance(0.05)
    sim.change(sim.scene.model_copy(update={"colliders": sim.scene.colliders[:1]}))
    sim.advance(0.02)
    assert len(sim.solver.solids) == 2  # the ground and the body


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"numerics": {"device": "cuda"}}, 'numerics.device = "cuda" has no numerics.method = "sph"'),
        ({"heat": {"air_temperature": 1.0}}, 'numerics.method = "sph" knows no heat'),
        (
            {"sinks": [{"shape": "box", "size": [1, 1, 1]}]},
            'numerics.method = "sph" adds and removes no snow',
        ),
    ],
)
def test_what_it_cannot_is_one_sentence(more, sentence):
    """A device, heat, and snow that goes."""
    described = {"sources": [BALL], **more}
    described["numerics"] = {"method": "sph", "dx": 0.1} | more.get("numerics", {})
    with pytest.raises(SceneError, match=sentence):
        Simulation(scene_from(described))


def test_what_named_snows_are():
    """Constants of the law by those of the snow's own, and those that have no counterpart."""
    default = Snow()
    c = law_constants(default)
    assert (c["theta_c"], c["theta_s"], c["xi"]) == (0.025, 0.0075, 10.0)
    clay = law_constants(Snow(law="cam_clay"))
    own = Snow(law="cam_clay").constants()
    assert clay["theta_c"] == pytest.approx(own["p0"] * (1 - 2 * own["nu"]) / own["E0"])
    assert clay["theta_s"] == pytest.approx(own["beta"] * clay["theta_c"])
    bounds = law_constants(Snow(law="cam_clay", J_P_min=0.3, J_P_max=5.0))
    assert (bounds["J_P_min"], bounds["J_P_max"]) == (0.3, 5.0)
    sand = law_constants(Snow(law="drucker_prager"))
    assert sand["xi"] == 0.0
    assert sand["theta_c"] == 0.99


def test_snow_without_lateral_contraction():
    """nu = 0, so lam = 0: no pressure but that of G, and the limit of a small nu."""
    ends = []
    for nu in (0.0, 1e-4):
        sim = smoothed([BALL], WORLD[:1], (0.0, 0.0, -9.81), snow={"nu": nu})
        sim.advance(0.05)
        ends.append(np.asarray(sim.state.x))
    assert ends[0] == pytest.approx(ends[1], abs=1e-3 * sim.scene.numerics.dx)
