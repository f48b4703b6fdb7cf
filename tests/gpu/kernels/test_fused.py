"""The variant that gathers and scatters in one kernel does what the two kernels do, one after the other."""

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, advanced, assert_same, scene

import neve
from neve.cuda.stages import CudaStages
from neve.scene.reading.load import scene_from

SINGLE = 1e-5
FALLING = {**LUMP, "velocity": [3, 0, -6], "spin": [0, 20, 0]}


@pytest.fixture
def fused(monkeypatch):
    """Let runs take the variant; the kernels that were started."""
    started = []
    plain = CudaStages.launch

    def counted(stages, model, name, blocks, threads):
        started.append(name)
        plain(stages, model, name, blocks, threads)

    monkeypatch.setattr(CudaStages, "fused", True)
    monkeypatch.setattr(CudaStages, "launch", counted)
    return started


def both(document, fused, monkeypatch, seconds=0.02):
    """The run of two kernels, and that of the variant, each in one advance; and what the variant started."""
    runs = []
    for variant in (False, True):
        monkeypatch.setattr(CudaStages, "fused", variant)
        fused.clear()
        numerics = {**document["numerics"], "device": "cuda"}
        runs.append(neve.Simulation(scene_from({**document, "numerics": numerics}), threads=1))
        runs[-1].advance(seconds, lambda: False)
    return *runs, list(fused)


@pytest.mark.parametrize("transfer", ["apic", "pic"])
@pytest.mark.parametrize("spline", ["quadratic", "cubic"])
def test_as_two_kernels(some_gpu, fused, monkeypatch, transfer, spline):
    """A lump that lands and rolls: the same within rounding of float32; most steps need no p2g."""
    ball = {"shape": "sphere", "radius": 0.2, "center": [0.2, 0, 0]}
    document = scene(
        FLOOR, ball, source=FALLING, precision="float32", transfer=transfer, spline=spline, dt=2e-4
    )
    two, one, started = both(document, fused, monkeypatch)
    assert two.steps == one.steps > 50
    assert_same(two, one, 3 * SINGLE)
    assert started.count("g2p2g") == one.steps - one.stats.rejected
    assert started.count("p2g") < one.steps / 2
    assert some_gpu is None or not some_gpu.overrun()


def test_steps_that_the_host_chooses(some_gpu, fused, monkeypatch):
    """The next dt need not be known when forces are scattered."""
    two, one, _ = both(scene(FLOOR, source=FALLING, precision="float32"), fused, monkeypatch)
    assert two.steps == one.steps
    assert_same(two, one, 10 * SINGLE)


def test_steps_that_are_rejected(gpu, fused, monkeypatch):
    """What was scattered for a step is used up by its first attempt: the second scatters anew."""
    fast = {**LUMP, "velocity": [0, 0, -60], "size": [0.15, 0.15, 0.15]}
    document = scene(FLOOR, source=fast, precision="float32", dt=4e-4)
    two, one, _ = both(document, fused, monkeypatch, seconds=0.006)
    assert one.stats.rejected == two.stats.rejected > 0
    np.testing.assert_allclose(one.diagnostics().momentum, two.diagnostics().momentum, rtol=1e-3, atol=1e-2)


def test_what_is_written_counts(gpu, fused):
    """After the state was written to, nothing that was scattered before is used."""
    sim = advanced(scene(precision="float32", source=LUMP), "cuda")
    sim.state.v[:] = np.array([0.0, 1.0, 2.0])
    sim.state.C[:] = 0.0
    before = sim.diagnostics().momentum
    sim.advance(1e-3)
    after = np.array(sim.diagnostics().momentum) - [0, 0, -9.81e-3 * sim.diagnostics().mass]
    np.testing.assert_allclose(after, before, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize(
    "numerics",
    [{"transfer": "aflip"}, {"precision": "float64"}, {"deterministic": True}, {"devices": [0, 0]}],
)
def test_where_it_does_not_fit(gpu, fused, numerics):
    """Other runs take the two kernels."""
    document = scene(FLOOR, **{"precision": "float32", **numerics})
    advanced(document, "cuda")
    assert "g2p2g" not in fused
    assert "p2g" in fused
