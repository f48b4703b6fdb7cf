"""Runs on several GPUs, by stand-ins alone: who waits for whom, other numbers of GPUs, and faults."""

import gc

import numpy as np
import pytest
from gpu.runs import FIELDS, FLOOR, WIDE, advanced, scene, several

import neve
from neve.cli import main
from neve.cuda.driver import Driver
from neve.cuda.errors import DeviceError
from neve.scene.reading.load import scene_from
from neve.solver import Blowup


@pytest.mark.parametrize("deterministic", [False, True])
@pytest.mark.parametrize("late", [1, 2])
def test_whoever_must_wait_does(gpus, late, deterministic):
    """Streams that work as late as they may change no bit: nothing is read before it is there."""
    document = several(scene(FLOOR, source=WIDE, precision="float32"), (0, 1, 2), deterministic=deterministic)
    soon = advanced(document, "cuda")
    gpus.set(late=late)
    other = advanced(document, "cuda")
    for name in ("x", "v", "F_E", "id"):
        np.testing.assert_array_equal(getattr(other.state, name), getattr(soon.state, name))


def test_memory_and_streams_are_given_back(gpus):
    """On every GPU, when the simulation is gone."""
    gc.collect()
    before, lanes = gpus.used(), gpus.lanes()
    sim = advanced(several(scene(FLOOR, source=WIDE), (0, 1, 2)), "cuda")
    assert gpus.used() > before
    assert gpus.lanes() == lanes + 3
    del sim
    gc.collect()
    assert (gpus.used(), gpus.lanes()) == (before, lanes)


def code_of(*arguments):
    """The exit code of a command."""
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return end.value.code


def test_resumed_on_another_number_of_gpus(gpus, tmp_path):
    """Begun on two, resumed on three, or on one: with numerics.deterministic the bits of a run on one."""
    ends = []
    for k, (first, then) in enumerate([((0,), (0,)), ((0, 1), (0, 1, 2)), ((0, 1), (0,))]):
        out, path = str(tmp_path / f"run{k}"), tmp_path / f"scene{k}.toml"
        for devices, more in ((first, ("--frames", "1")), (then, ("--resume",))):
            path.write_text(
                "[run]\nfps = 250\nduration = 0.008\nfilm = false\n"
                f"[numerics]\ndx = 0.05\ndeterministic = true\ndevice = 'cuda'\ndevices = {list(devices)}\n"
                f"[[sources]]\nshape = 'box'\nsize = {WIDE['size']}\ncenter = {WIDE['center']}\n"
                f"velocity = {WIDE['velocity']}\n[[colliders]]\nshape = 'plane'\n"
            )
            assert code_of("run", str(path), "--out", out, "--quiet", *more) == 0
        with np.load(f"{out}/checkpoint") as end:
            rows = np.argsort(end["state.id"])
            ends.append({name: end[f"state.{name}"][rows] for name in FIELDS} | {"steps": end["state.steps"]})
    for name, array in ends[0].items():
        for other in ends[1:]:
            np.testing.assert_array_equal(other[name], array, err_msg=name)


@pytest.mark.parametrize(
    ("devices", "says"),
    [
        ("[0, 3]", "numerics.devices has GPU 3, and the GPUs here are 0 to 2"),
        ("[]", "numerics.devices"),
        ("[-1]", "numerics.devices"),
    ],
)
def test_gpus_that_are_not_there(gpus, library, monkeypatch, tmp_path, capsys, devices, says):
    """One sentence, exit code 2."""
    monkeypatch.setattr("neve.cuda.backend.driver", lambda number: Driver(number, str(library)))
    path = tmp_path / "scene.toml"
    path.write_text(
        f"[numerics]\ndevice = 'cuda'\ndevices = {devices}\n[[sources]]\nshape = 'sphere'\nradius = 0.2\n"
    )
    assert code_of("run", str(path), "--out", str(tmp_path / "run")) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert says in error


def test_devices_without_cuda_are_told_of(recwarn):
    """A list of GPUs has no effect on the processor."""
    neve.Simulation(scene_from(scene(FLOOR, devices=[0, 1])))
    assert any(
        'numerics.devices = [0, 1] has no effect with device = "cpu"' in str(w.message) for w in recwarn
    )


@pytest.mark.parametrize("kernel", ["unpack_halo", "g2p"])
def test_a_kernel_that_fails(gpus, kernel):
    """Ends the run, which can be resumed."""
    sim = advanced(several(scene(FLOOR, source=WIDE), (0, 1)), "cuda", calls=1)
    gpus.fail(kernel)
    with pytest.raises((Blowup, DeviceError), match=r"has failed .*last checkpoint"):
        sim.advance(1e-3)


@pytest.mark.parametrize("field", ["x", "m"])
def test_what_no_snow_has_is_named(gpus, field):
    """As on one GPU, whichever domain it is in; and the densest is the same particle."""
    said = []
    for devices in ((0,), (0, 1, 2)):
        sim = advanced(several(scene(FLOOR, source=WIDE), devices), "cuda", calls=1)
        sim.state.V0[np.asarray(sim.state.id) == 40] *= 0.4
        solver = sim.solver
        row, _, densest, crowding = solver.model.core.inspect(solver.model.native, sim.state)
        assert (row, int(sim.state.id[densest])) == (-1, 40)
        getattr(sim.state, field)[np.asarray(sim.state.id) == 40] = np.nan
        with pytest.raises(Blowup) as error:
            sim.advance(1e-3)
        said.append((str(error.value), crowding))
    assert said[0] == said[1]


def test_a_lost_particle(gpus):
    """Beyond the lattice: the same sentence as on one."""
    sim = advanced(several(scene(FLOOR, source=WIDE), (0, 1)), "cuda", calls=1)
    sim.state.x[5] = 1e9
    with pytest.raises(Blowup, match="beyond the lattice"):
        sim.advance(1e-3)
