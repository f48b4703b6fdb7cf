"""Steps that the GPU chooses and judges itself, several without the host: those that the host would take."""

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, advanced, assert_same, by_id, scene

import neve
from neve.cuda.stages import CudaStages
from neve.scene.reading.load import scene_from
from neve.solver import Blowup

FALLING = {**LUMP, "center": [0, 0, 0.5]}


@pytest.fixture
def batches(monkeypatch):
    """How many steps each call without the host took, and the report of the last."""
    found = []
    plain = CudaStages.run_ahead

    def counted(*arguments):
        steps, report = plain(*arguments)
        found.append((len(steps), report))
        return steps, report

    monkeypatch.setattr(CudaStages, "run_ahead", counted)
    return found


def simulated(document, seconds, device, ahead=True):
    """A simulation that was advanced in one call; with `ahead` false the host looks at each step."""
    document = {**document, "numerics": {**document["numerics"], "device": device}}
    sim = neve.Simulation(scene_from(document), threads=1)
    sim.advance(seconds, None if ahead else lambda: False)
    return sim


CHOICES = {
    "apic": {},
    "flip that fades": {"transfer": "flip", "flip_damping": 50.0},
    "aflip": {"transfer": "aflip"},
    "a step of the user's": {"dt": 1.3e-4},
    "float32": {"precision": "float32"},
    "play": {"spline": "cubic"},
}


@pytest.mark.parametrize("choice", list(CHOICES))
def test_as_the_host_would(gpu, batches, choice):
    """A lump that lands: the same steps, bound by the same, to the same state, and most without the host."""
    mode = "slip" if choice == "play" else "separate"
    document = scene({**FLOOR, "mode": mode}, **CHOICES[choice])
    other, cpu = simulated(document, 0.02, "cuda", ahead=False), simulated(document, 0.02, "cpu")
    assert batches == []
    sim = simulated(document, 0.02, "cuda")
    assert max(count for count, _ in batches) > 4
    assert sum(count for count, _ in batches) > 0.7 * sim.steps
    assert (sim.steps, sim.time) == (cpu.steps, cpu.time)
    tolerance = 1e-5 if choice == "float32" else 1e-12
    assert (sim.stats.bound, sim.stats.rejected) == (cpu.stats.bound, cpu.stats.rejected)
    assert sim.stats.dt_min == pytest.approx(cpu.stats.dt_min, rel=tolerance)
    assert_same(cpu, sim, 10 * tolerance)
    assert_same(other, sim, tolerance)
    assert gpu.graphs(launches=True) > 0
    assert not gpu.overrun()


def test_a_step_that_must_be_tried_is_left_to_the_host(gpu, batches):
    """Fast snow that bursts on the floor: some steps are rejected, and none of them moved a particle."""
    fast = {**LUMP, "velocity": [0, 0, -60], "size": [0.15, 0.15, 0.15]}
    document = scene(FLOOR, source=fast, dt=4e-4)
    cpu, sim = simulated(document, 0.01, "cpu"), simulated(document, 0.01, "cuda")
    assert cpu.stats.rejected > 0
    assert sim.stats.rejected == cpu.stats.rejected
    assert any(count == 0 for count, _ in batches)
    assert_same(cpu, sim, 1e-9)


def test_it_halts_where_particles_drift(gpu, batches):
    """Snow that falls crosses blocks: each time the host sorts, and the steps go on."""
    document = scene(source={**FALLING, "velocity": [8, 0, -8]})
    cpu, sim = simulated(document, 0.05, "cpu"), simulated(document, 0.05, "cuda")
    assert any(report.drifted for _, report in batches)
    assert_same(cpu, sim, 1e-11)


def test_it_halts_where_a_number_breaks(gpu, batches):
    """A deformation that is none, which only g2p reads, ends the run at its step, in the usual sentence."""
    said = []
    for device in ("cpu", "cuda"):
        sim = advanced(scene(FLOOR), device, calls=1)
        sim.solver.begin(sim.steps, sim.time)
        sim.state.F_E[np.asarray(sim.state.id) == 40] = np.nan
        if device == "cuda":
            sim.state.upload()
        steps = sim.solver.take_steps(sim.steps, sim.time, 1e-3, 64)
        assert len(steps) == 1
        with pytest.raises(Blowup) as error:
            sim.solver.end_step(sim.steps + 1, sim.time, steps[0].dt)
        said.append(str(error.value))
    assert batches[-1][0] == 1
    assert "particle 40" in said[0]
    assert said[0] == said[1]


def test_looking_at_each_step_takes_them_one_by_one(gpu, batches):
    """Who is asked after each substep may read the state of that step."""
    seen = []
    sim = neve.Simulation(scene_from(scene(source=FALLING, device="cuda")))
    start = by_id(sim, "x")[0].copy()
    sim.advance(2e-3, lambda: seen.append(by_id(sim, "x")[0] - start) or False)
    assert batches == []
    assert len(seen) == sim.steps
    assert (np.diff([way[2] for way in seen]) < 0).all()


def test_solids_that_move_need_the_host(gpu, batches):
    """Their place is asked for at each step."""
    turning = {"shape": "sphere", "radius": 0.2, "center": [0, 0, -0.2], "spin": [0, 60, 0]}
    advanced(scene(turning), "cuda")
    assert batches == []


@pytest.mark.parametrize("graphs", [True, False])
def test_with_and_without_graphs(gpu, monkeypatch, graphs):
    """A driver that has none gets the launches one by one; graphs are given back."""
    if not graphs:
        monkeypatch.setattr(type(gpu), "captured", lambda *_: None)
    launched = gpu.graphs(launches=True)
    sim = simulated(scene(FLOOR), 0.01, "cuda")
    assert (gpu.graphs(launches=True) > launched) == graphs
    assert_same(simulated(scene(FLOOR), 0.01, "cpu"), sim, 1e-12)
    del sim
    assert gpu.graphs() == 0


def test_bits_do_not_depend_on_how_many_at_once(gpu, monkeypatch):
    """With numerics.deterministic: one by one, or as many as the GPU takes."""
    document = scene(FLOOR, precision="float32", deterministic=True)
    runs = [simulated(document, 0.01, "cuda", ahead) for ahead in (True, False)]
    for name in ("x", "v", "C", "F_E", "J_P"):
        np.testing.assert_array_equal(*(np.array(getattr(sim.state, name)) for sim in runs))


def test_their_time_is_booked_apart(gpu, batches):
    """Steps without the host count as "ahead"; p2g, grid and g2p have the time of the others."""
    sim = simulated(scene(FLOOR), 0.01, "cuda")
    alone = simulated(scene(FLOOR), 0.01, "cuda", ahead=False)
    assert sum(count for count, _ in batches) > 0.7 * sim.steps
    assert sim.stats.stage_seconds["ahead"] > 0
    assert alone.stats.stage_seconds["ahead"] == 0
    assert min(alone.stats.stage_seconds[name] for name in ("p2g", "grid", "g2p")) > 0
