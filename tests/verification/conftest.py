"""With NEVE_TEST_DEVICE=cuda the tests that look at results alone run on the GPU: `pytest -m gpu`."""

import os

import pytest

from neve.backend import backend

ON_DEVICE = (
    "experiments/", "rigid/test_bodies_in_snow", "rigid/test_two_way", "snow/test_energy_accounts",
    "solids/test_43", "solids/test_ground", "solids/test_thin_solids", "solids/test_curved_surfaces",
    "step/test_07", "step/test_08", "step/test_oracle", "step/test_energy_bounds", "step/test_stable_step",
    "step/test_time_step", "transfers/test_04", "transfers/test_05", "transfers/test_06",
)  # fmt: skip
"""Files whose tests make runs and look at what they leave: none calls a stage, or asks for equal bits."""


def pytest_collection_modifyitems(items):
    """Mark them."""
    for item in items:
        if any(f"verification/{name}" in item.path.as_posix() for name in ON_DEVICE):
            item.add_marker(pytest.mark.gpu)


@pytest.fixture(autouse=True)
def on_device(request, monkeypatch):
    """Let what runs on the processor run on that device."""
    word = os.environ.get("NEVE_TEST_DEVICE")
    if word and request.node.get_closest_marker("gpu"):
        monkeypatch.setattr("neve.mpm.model.backend", lambda _: backend(word))
