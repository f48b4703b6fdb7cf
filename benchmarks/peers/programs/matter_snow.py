"""The block in Matter, a program of C++ that `matter_build.py` makes (see `matter_snow.cpp`).

Another law, Modified Cam-Clay, in double precision, with Matter's own transfer (AFLIP) and its own time step,
half a cell at the speed of elastic waves. Particles, cell size, density, elasticity and ground are those of
the case.
"""

from __future__ import annotations

import atexit
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from case import Case


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision, version = "Cam-Clay, Hencky", "float64", "v1"

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`, on the processor."""
        if device != "cpu":
            raise RuntimeError("Matter runs on processors only")
        self.particles = len(case.x)
        self.dt = 0.5 * case.dx / (case.E0 / case.rho0) ** 0.5
        order = case.by_rows()
        volume = float(case.V0.mean())
        head = (self.particles, case.dx, case.rho0, case.E0, case.nu, case.gravity, case.mu_c, volume)
        with tempfile.NamedTemporaryFile(delete=False) as file:
            np.array(head, dtype=np.float64).tofile(file)
            np.concatenate((case.x[order], case.v[order]), axis=1, dtype=np.float64).tofile(file)
        atexit.register(Path(file.name).unlink, missing_ok=True)
        program = Path(sys.prefix) / "matter_snow"
        command = [str(program), file.name, str(threads)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate `seconds`."""
        asked, answers = self._process.stdin, self._process.stdout
        if not asked or not answers:
            raise RuntimeError("Matter has no standard streams")
        asked.write(f"{seconds!r}\n".encode())
        asked.flush()
        answer = answers.readline()
        if not answer:
            raise RuntimeError("Matter has ended")
        return int(answer), seconds

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x, v."""
        out, _ = self._process.communicate(b"\n")
        rows = np.frombuffer(out, dtype=np.float64).reshape(-1, 6)
        return rows[:, :3], rows[:, 3:], None
