"""Which device is taken, and what is said where it cannot: one sentence, exit code 2."""

import logging
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from gpu.runs import FLOOR, LUMP, SECONDS, advanced, assert_same, scene

import neve
from neve import _core
from neve.cli import main
from neve.cuda import driver, program
from neve.cuda.errors import DeviceError, NoDevice
from neve.mpm.model import Model
from neve.scene.reading.load import scene_from
from neve.solver import Blowup

BODY = {"shape": "sphere", "radius": 0.1, "center": [0, 0, 0.5], "density": 500}


@pytest.fixture
def no_gpu(monkeypatch):
    """A machine without the driver of a GPU."""
    monkeypatch.setattr(driver.Driver.__init__, "__defaults__", ("libcuda-of-no-machine.so",))
    driver.driver.cache_clear()
    yield
    driver.driver.cache_clear()


def code_of(*arguments):
    """The exit code of a command."""
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return end.value.code


def core_of(device, **more):
    """The stages of a scene's model."""
    return neve.Simulation(scene_from({**scene(FLOOR, device=device), **more})).solver.model.core


def test_no_gpu_is_one_sentence(no_gpu, tmp_path, capsys):
    """`neve run --device cuda` ends with exit code 2 and says what to do; nothing is left behind."""
    code = code_of("run", "throw_ball", "--device", "cuda", "--out", str(tmp_path / "run"))
    error = capsys.readouterr().err
    assert code == 2
    assert error.count("\n") == 1
    assert 'numerics.device = "cuda" needs a GPU: there is no driver of NVIDIA' in error
    assert 'use "cpu" or "auto"' in error


def test_auto_without_a_gpu_is_the_processor(no_gpu):
    """The same stages as with "cpu", and no word about it."""
    assert core_of("auto") is _core.f64


def test_auto_with_a_gpu_is_the_gpu(gpu):
    """Bodies and all."""
    assert core_of("auto") is not _core.f64
    assert core_of("auto", bodies=[BODY]) is not _core.f64


@pytest.mark.parametrize(
    ("version", "found", "says"),
    [
        ((12, 4), [(13, 5)], "knows CUDA 12.4, and the compiler is of 13.5.*nvrtc-cu12"),
        ((13, 1), [], "no compiler"),
    ],
)
def test_compiler_must_fit_the_driver(monkeypatch, version, found, says):
    """A compiler newer than the driver makes code that it cannot load; a lack of one is said as well."""
    made = [type("Found", (), {"version": each})() for each in found]
    monkeypatch.setattr(program, "libraries", lambda: list(range(len(made))))
    monkeypatch.setattr(program, "Compiler", lambda which: made[which])
    with pytest.raises(NoDevice, match=says):
        program.compiler(version)


def test_newest_compiler_that_fits(monkeypatch):
    """Of several wheels."""
    made = [type("Found", (), {"version": each})() for each in [(12, 9), (13, 5), (14, 0)]]
    monkeypatch.setattr(program, "libraries", lambda: [0, 1, 2])
    monkeypatch.setattr(program, "Compiler", lambda which: made[which])
    assert program.compiler((13, 0)).version == (13, 5)


def test_machine_code_is_kept(monkeypatch):
    """The second use does not compile; another architecture, choice or source does."""
    compiled = []

    class Counting:
        version = (13, 5)
        options = staticmethod(program.Compiler.options)

        def compiled(self, choice, architecture, step_bytes):
            compiled.append((choice, architecture))
            return b"code of " + str(architecture).encode(), ""

    monkeypatch.setattr(program, "compiler", lambda newest: Counting())
    choice = program.Choice("float32", 0, 0, 8, 1, False, False)
    for architecture in (80, 80, 90):
        assert program.cubin(choice, architecture, (13, 5), 1) == b"code of " + str(architecture).encode()
    program.cubin(choice._replace(solids=True), 90, (13, 5), 1)
    monkeypatch.setattr(program, "_text", lambda: b"other sources")
    program.cubin(choice, 90, (13, 5), 1)
    assert len(compiled) == 4


def test_too_little_memory(gpu):
    """The sentence says how much is needed and free, and by how much to coarsen."""
    gpu.set(memory=gpu.used() + 150_000)
    with pytest.raises(
        DeviceError, match=r"particles need about .* MB on shim, .*so raise numerics.dx [\d.]+ times"
    ):
        neve.Simulation(scene_from(scene(FLOOR, device="cuda")))


def test_memory_that_ends_in_a_run(gpu):
    """A grid that grows beyond what is left ends the run in one sentence."""
    sim = neve.Simulation(scene_from(scene(FLOOR, device="cuda")))
    gpu.set(memory=gpu.used() + 50_000)
    with pytest.raises(DeviceError, match=r"shim has .* of memory left, and .* more are needed: raise"):
        sim.advance(1e-3)


def test_memory_is_given_back(gpu):
    """When the simulation is gone."""
    before = gpu.used()
    sim = advanced(scene(FLOOR), "cuda")
    assert gpu.used() > before
    del sim
    assert gpu.used() == before


def test_a_kernel_that_fails(gpu):
    """The sentence names the stage and the checkpoint."""
    stages = {"g2p": lambda: False, "p2g, grid or g2p": None}  # step by step, or several without the host
    for stage, enough in stages.items():
        gpu.fail()
        sim = advanced(scene(FLOOR), "cuda", calls=1)
        gpu.fail("g2p")
        said = rf"failed in the stage {stage} \(CUDA_ERROR_LAUNCH_FAILED\).*last checkpoint"
        with pytest.raises(Blowup, match=said):
            sim.advance(1e-3, enough)


def test_checkpoints_move_between_devices(gpu, tmp_path, caplog):
    """A run that is begun on one device and resumed on the other ends as one that stayed."""
    path = tmp_path / "scene.toml"
    path.write_text(
        "[run]\nfps = 250\nduration = 0.008\nfilm = false\n[numerics]\ndx = 0.05\nprecision = 'float64'\n"
        f"[[sources]]\nshape = 'box'\nsize = {LUMP['size']}\ncenter = {LUMP['center']}\n"
        f"velocity = {LUMP['velocity']}\n[[colliders]]\nshape = 'plane'\n"
    )
    caplog.set_level(logging.ERROR)
    for first, then in (("cpu", "cuda"), ("cuda", "cpu")):
        out = str(tmp_path / first)
        assert code_of("run", str(path), "--device", first, "--out", out, "--frames", "1", "--quiet") == 0
        assert code_of("run", out, "--resume", "--device", then, "--quiet") == 0
    x = []
    for name in ("cpu", "cuda"):
        with np.load(tmp_path / name / "frames" / "000002.npz") as end:
            x.append(end["x"][np.argsort(end["id"])] if "id" in end else end["x"])
    np.testing.assert_allclose(x[0], x[1], rtol=0, atol=1e-6)


def test_a_lost_particle(gpu):
    """Beyond the lattice: the same sentence as on the processor."""
    sim = advanced(scene(FLOOR), "cuda", calls=1)
    sim.state.x[5] = 1e9
    with pytest.raises(Blowup, match="beyond the lattice"):
        sim.advance(1e-3)


@pytest.mark.parametrize(
    ("field", "value"), [("x", np.nan), ("F_E", 0.0), ("m", -1.0), ("strength", -0.5), ("material", 7)]
)
def test_what_no_snow_has_is_named(gpu, field, value):
    """Found on the GPU, named as on the processor."""
    said = []
    for device in ("cpu", "cuda"):
        sim = advanced(scene(FLOOR), device, calls=1)
        row = int(np.flatnonzero(np.asarray(sim.state.id) == 40)[0])
        getattr(sim.state, field)[row] = value
        with pytest.raises(Blowup) as error:
            sim.advance(1e-3)
        said.append(str(error.value))
    assert said[0] == said[1]


def test_densest_particle(gpu):
    """The same particle and nearly the same number as the processor finds."""
    found = []
    for device in ("cpu", "cuda"):
        sim = advanced(scene(FLOOR), device, calls=1)
        sim.state.V0[np.asarray(sim.state.id) == 40] *= 0.4
        solver = sim.solver
        row, _, densest, crowding = solver.model.core.inspect(solver.model.native, sim.state)
        assert row == -1
        found.append((int(sim.state.id[densest]), crowding))
    assert found[0][0] == found[1][0] == 40
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-6)


def test_what_is_written_counts_from_the_next_advance(gpu):
    """Velocities set between two advances, as on the processor."""
    cpu, other = advanced(scene(), "cpu", calls=1), advanced(scene(), "cuda", calls=1)
    for sim in (cpu, other):
        sim.state.v[:] = np.array([0.0, 1.0, 2.0])
        sim.advance(1e-3)
    assert_same(cpu, other, 1e-12)


def test_any_thread_of_the_host(gpu):
    """A simulation made in one thread is advanced and looked at in others, as the viewer does."""
    here = advanced(scene(FLOOR), "cuda")
    sim = advanced(scene(FLOOR), "cuda", calls=1)
    with ThreadPoolExecutor(1) as one, ThreadPoolExecutor(1) as other:
        one.submit(sim.advance, SECONDS).result()
        x = other.submit(lambda: np.array(sim.state.x)).result()
    np.testing.assert_allclose(x, np.asarray(here.state.x), rtol=0, atol=1e-12)


def test_model_of_the_core_answers(gpu):
    """What is not of the step is asked of the core's own model."""
    model = neve.Simulation(scene_from(scene(FLOOR, device="cuda"))).solver.model
    assert isinstance(model, Model)
    assert model.distance(0, np.array([[0.0, 0.0, 2.0]])) == pytest.approx(2.0)
