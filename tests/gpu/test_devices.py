"""What `neve info` and `neve estimate` say of GPUs."""

import json
from types import SimpleNamespace

import pytest
from gpu.runs import FLOOR, scene

from neve.cli import main
from neve.cli.estimate import as_data, as_text
from neve.cuda import devices
from neve.cuda.errors import NoDevice
from neve.run.estimate import estimate
from neve.scene.reading.load import scene_from


@pytest.fixture
def found(gpu, monkeypatch):
    """The stand-in, with a compiler."""
    monkeypatch.setattr(devices, "driver", lambda: gpu)
    monkeypatch.setattr(devices, "compiler", lambda newest: SimpleNamespace(version=(12, 9)))
    return gpu


def told(capsys, *arguments):
    """What a command prints."""
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 0
    return capsys.readouterr().out


def test_info_names_the_gpu(found, capsys):
    """Its name, compute capability and memory, what is free of it, and both versions of CUDA."""
    found.set(memory=4_000_000_000)
    facts = json.loads(told(capsys, "info", "--json"))
    assert facts["gpus"] == [
        {
            "name": "shim",
            "compute_capability": "9.0",
            "memory": 4_000_000_000,
            "memory_free": 4_000_000_000 - found.used(),
        }
    ]
    assert (facts["cuda_of_driver"], facts["cuda_of_compiler"], facts["gpu_advice"]) == ("13.1", "12.9", None)
    assert "gpus: shim (compute capability 9.0, 4 GB, 4 GB free)" in told(capsys, "info").splitlines()


def test_info_numbers_several(gpus, monkeypatch, capsys):
    """As numerics.devices takes them."""
    monkeypatch.setattr(devices, "driver", lambda: gpus)
    monkeypatch.setattr(devices, "compiler", lambda newest: SimpleNamespace(version=(12, 9)))
    line = next(line for line in told(capsys, "info").splitlines() if line.startswith("gpus: "))
    assert line.startswith("gpus: 0: shim (")
    assert ", 2: shim (compute capability 9.0" in line


def test_info_says_why_there_is_none(monkeypatch, capsys):
    """In the words of the error, and the command succeeds."""

    def lacking():
        raise NoDevice("there is no driver of NVIDIA (libcuda.so.1 is not installed)")

    monkeypatch.setattr(devices, "driver", lacking)
    lines = told(capsys, "info").splitlines()
    assert "gpus: none" in lines
    assert "gpu_advice: there is no driver of NVIDIA (libcuda.so.1 is not installed)" in lines


def test_estimate_on_a_gpu(gpu):
    """The trial runs there; its memory stands beside that of the machine, and what is too much is told."""
    document = scene_from({**scene(FLOOR, device="cuda", precision="float32"), "run": {"duration": 0.05}})
    taken = estimate(document, seconds=1.0)
    assert taken.device == "shim"
    assert 512 * 4 * 35 < taken.device_memory < 4e6  # more than the columns, of 512 particles
    assert as_data(taken)["device_memory_bytes"] == round(taken.device_memory)
    line = next(line for line in as_text(taken, document) if line.startswith("of the GPU"))
    assert line.endswith("GB are free")
    gpu.set(memory=gpu.used() + 1000)
    few = estimate(scene_from({**scene(FLOOR, precision="float32"), "run": {"duration": 0.05}}), seconds=0.5)
    assert few.device == ""
    assert not any(line.startswith("of the GPU") for line in as_text(few, document))
