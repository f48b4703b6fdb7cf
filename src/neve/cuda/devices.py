"""What `neve info` says of the GPUs of this machine, and whether the first can be used."""

from __future__ import annotations

from typing import Any

from neve.cuda.driver import driver
from neve.cuda.errors import NoDevice
from neve.cuda.program import compiler
from neve.system.memory import in_words


def facts() -> dict[str, Any]:
    """Return the GPUs, the CUDA of driver and compiler, and why `numerics.device = "cuda"` cannot be used.

    `gpus`: of each its name, compute capability and memory [bytes], of the first what is free of it; the
    rest: text, or None where there is none.
    """
    out: dict[str, Any] = {"gpus": [], "cuda_of_driver": None, "cuda_of_compiler": None, "gpu_advice": None}
    try:
        gpu = driver()
        out["gpus"] = gpu.devices()
        out["gpus"][0]["memory_free"] = gpu.memory()[0]
        out["cuda_of_driver"] = "{}.{}".format(*gpu.version)
        out["cuda_of_compiler"] = "{}.{}".format(*compiler(gpu.version).version)
    except NoDevice as error:
        out["gpu_advice"] = str(error)
    return out


def in_text(found: dict[str, Any]) -> dict[str, str]:
    """Return the same as text."""
    several = len(found["gpus"]) > 1
    gpus = [
        (f"{number}: " if several else "")
        + f"{gpu['name']} (compute capability {gpu['compute_capability']}, {in_words(gpu['memory'])}"
        + (f", {in_words(gpu['memory_free'])} free)" if "memory_free" in gpu else ")")
        for number, gpu in enumerate(found["gpus"])
    ]
    return {
        "gpus": ", ".join(gpus) or "none",
        "cuda_of_driver": found["cuda_of_driver"] or "none",
        "cuda_of_compiler": found["cuda_of_compiler"] or "none",
        "gpu_advice": found["gpu_advice"]
        or 'none: numerics.device = "cuda" uses the first, or those that numerics.devices names',
    }
