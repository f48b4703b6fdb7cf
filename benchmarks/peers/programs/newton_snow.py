"""The block in Newton's implicit material point solver, with the rheology and settings of its snow ball.

Another method and another law: each step solves for velocities and stresses together, so steps are long;
snow is a cohesive granular solid whose yield pressure hardens. Particles, cell size, density, elasticity and
ground are those of the case; the rest is what Newton's example of a snow ball uses.
"""

from __future__ import annotations

from importlib.metadata import version

import newton
import numpy as np
import warp as wp
from case import Case
from newton.solvers import SolverImplicitMPM

DT = 1.0 / 240.0
"""A quarter of the example's step [s]: the block falls 21 mm in it, one cell."""
RHEOLOGY = {
    "friction": 0.5,
    "damping": 0.01,
    "yield_pressure": 1.4e6,
    "tensile_yield_ratio": 0.2,
    "yield_stress": 0.0,
    "hardening": 5.0,
    "dilatancy": 1.0,
}
SETTINGS = {"solver": ("cg", "gauss-seidel"), "strain_basis": "P0", "max_iterations": 150, "tolerance": 1e-4}


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision, dt = "Cam-Clay with hardening, implicit", "float32", DT

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`; device: "cpu" or "cuda"."""
        self.version = version("newton")
        wp.config.quiet = True
        wp.set_device("cuda:0" if device == "cuda" else "cpu")
        builder = newton.ModelBuilder()
        SolverImplicitMPM.register_custom_attributes(builder)
        builder.add_ground_plane(cfg=newton.ModelBuilder.ShapeConfig(mu=case.mu_c))
        order = case.by_rows()
        self.particles = len(order)
        radius = 0.5 * float(case.V0.mean()) ** (1 / 3)
        builder.add_particles(
            pos=case.x[order].tolist(),
            vel=case.v[order].tolist(),
            mass=case.m[order].tolist(),
            radius=[radius] * self.particles,
        )
        model = builder.finalize()
        model.set_gravity((0.0, 0.0, case.gravity))
        model.mpm.young_modulus.fill_(case.E0)
        model.mpm.poisson_ratio.fill_(case.nu)
        for name, value in RHEOLOGY.items():
            getattr(model.mpm, name).fill_(value)
        config = SolverImplicitMPM.Config()
        for name, value in (SETTINGS | {"voxel_size": case.dx}).items():
            if not hasattr(config, name):
                raise AttributeError(f"this version of Newton has no setting {name}")
            setattr(config, name, value)
        self.now, self.next = model.state(), model.state()
        self.now.mpm.particle_Jp.fill_(0.975)
        self.solver = SolverImplicitMPM(model, config)

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate whole steps, `seconds` at least."""
        steps = max(1, round(seconds / DT + 0.49))
        for _ in range(steps):
            self.solver.step(self.now, self.next, None, None, DT)
            self.now, self.next = self.next, self.now
        wp.synchronize()
        return steps, steps * DT

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x, v; its J_P means something else."""
        return self.now.particle_q.numpy(), self.now.particle_qd.numpy(), None
