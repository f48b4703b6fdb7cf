"""The block in Nexus, by its Python package, where that has a snow model and the machine WebGPU.

An explicit step of its own with the same law; no particles come back to Python, so only times are compared.
"""

from __future__ import annotations

from importlib.metadata import version

import nexus3d
import numpy as np
from case import Case

DT = 1.0 / 60.0
"""Of a frame [s]; Nexus divides it into steps by itself."""


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision, dt = "Stomakhin 2013", "float32", DT

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`."""
        self.version = version("dimforge-nexus3d")
        snow = getattr(nexus3d.ParticleModel, "snow", None)
        if snow is None:
            raise RuntimeError("the Python package of Nexus has no snow: elastic solids and sand only")
        self.particles = len(case.x)
        self._viewer = nexus3d.NexusViewer()
        self._viewer.init_backend()
        self._pipeline, self._state = nexus3d.NexusPipeline(), nexus3d.NexusState()
        model = snow(case.E0, case.nu)
        radius = 0.5 * float(case.V0.mean()) ** (1 / 3)
        particles = []
        for x, v in zip(case.x.tolist(), case.v.tolist(), strict=True):
            particle = nexus3d.Particle(nexus3d.vec3(x[0], x[2], -x[1]), radius, case.rho0, model)
            particle.velocity = nexus3d.vec3(v[0], v[2], -v[1])
            particles.append(particle)
        gravity = nexus3d.vec3(0.0, case.gravity, 0.0)
        self._state.set_mpm_params(self._viewer, nexus3d.SimulationParams(gravity, DT), case.dx)
        self._state.set_mpm_substeps(round(DT / case.dt))
        self._state.add_particles(self._viewer, particles)
        coupling = nexus3d.RbdCoupling.mpm_one_way(nexus3d.BoundaryCondition.separate(case.mu_c))
        ground = nexus3d.RigidBodyBuilder.fixed().translation(nexus3d.vec3(0.0, -1.0, 0.0)).build()
        box = nexus3d.ColliderBuilder.cuboid(20.0, 1.0, 20.0).build()
        self._state.insert_rigid_body(ground, box, coupling)
        self._state.finalize(self._viewer)
        self._steps = round(DT / case.dt)

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate whole frames, `seconds` at least, and wait for them."""
        frames = max(1, round(seconds / DT + 0.49))
        for _ in range(frames):
            self._pipeline.simulate(self._viewer, self._state)
        self._viewer.sync(self._state)
        return frames * self._steps, frames * DT

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Errors: RuntimeError, for there is none."""
        raise RuntimeError("Nexus gives no particles back to Python")
