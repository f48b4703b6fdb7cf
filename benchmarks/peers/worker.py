"""Run one program of `programs/` in its own environment, and answer on the standard output.

    python worker.py PROGRAM CASE.npz THREADS DEVICE

The module PROGRAM has a class `Program` (see `programs/neve_snow.py`). After a line with what the program is,
each line of the standard input is a number of seconds to simulate, to which a line answers with the wall time
[s], the steps taken and the seconds simulated; an empty line asks for the outcome and ends the program.
What the peer itself prints goes to the standard error.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

HERE = Path(__file__).parent
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def outcome(x: np.ndarray, v: np.ndarray, J_P: np.ndarray | None) -> dict[str, float]:
    """Return what programs of the same step must agree on: height, fall, spread, hardening, flow."""
    x, v = x.astype(np.float64), v.astype(np.float64)
    found = {
        "mean z [m]": float(x[:, 2].mean()),
        "mean v_z [m/s]": float(v[:, 2].mean()),
        "rms v_x [m/s]": float(np.sqrt((v[:, 0] ** 2).mean())),
        "rms x [m]": float(np.sqrt((x[:, 0] ** 2).mean())),
    }
    if J_P is not None:
        found["mean J_P"] = float(J_P.mean(dtype=np.float64))
        found["flowed"] = float((np.abs(J_P - 1) > 1e-5).mean())
    return found


def main() -> None:
    """Build the program, then take turns."""
    name, path, threads, device = sys.argv[1:]
    for variable in THREAD_VARIABLES:
        os.environ[variable] = threads
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    sys.path[:0] = [str(HERE), str(HERE / "programs")]

    def answer(**values: Any) -> None:
        print(json.dumps(values), file=answers, flush=True)

    from case import Case

    program = importlib.import_module(name).Program(Case.load(path), int(threads), device)
    told = ("version", "law", "precision", "dt", "particles")
    answer(**{key: getattr(program, key) for key in told})
    for line in iter(sys.stdin.readline, "\n"):
        if not line:
            return
        begun = perf_counter()
        steps, seconds = program.advance(float(line))
        answer(wall=perf_counter() - begun, steps=steps, seconds=seconds)
    answer(**outcome(*program.state()))
    os._exit(0)  # some peers crash when the interpreter ends


if __name__ == "__main__":
    main()
