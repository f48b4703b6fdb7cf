"""The step's functions of values are device code as they stand: no GPU is needed to see that they compile."""

from pathlib import Path

import pytest
from device import nvrtc


@pytest.mark.parametrize("architecture", [80, 90, 100])
def test_step_compiles_for_a_device(architecture):
    """Every law, transfer, spline and contact mode compiles for sm_80, sm_90 and sm_100, without a warning.

    Hardly optimised, since all of it would take minutes; what is not for a device is an error all the same.
    """
    library = nvrtc.compiler()
    if architecture not in nvrtc.architectures(library):
        pytest.skip(f"this NVRTC does not know sm_{architecture}")
    source = Path(__file__).with_name("step.cu").read_text(encoding="utf-8")
    taken, log, code = nvrtc.compiled(library, source, architecture)
    assert taken, log[-2000:]
    assert log == ""
    assert code.startswith(b"\x7fELF")


def test_what_is_not_device_code_is_an_error():
    """A standard header, which NVRTC lacks, is refused (else the test above could not fail)."""
    taken, log, _ = nvrtc.compiled(nvrtc.compiler(), "#include <vector>\n", 80)
    assert not taken
    assert "vector" in log
