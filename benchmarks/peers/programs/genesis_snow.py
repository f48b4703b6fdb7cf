"""The block in Genesis, with its snow: the same law and transfer, its own grid, sampling and contact.

Genesis fills the box itself, so the particles lie elsewhere and their number may differ. Its grid is
dense over the bounds, which are cut close to the block. The law is that of Stomakhin et al. 2013 with xi
= 10 and no bounds on J_P; the ground is a rigid plane with Genesis's own coupling. This has not been run
yet: Genesis could not be installed where the table was made.
"""

from __future__ import annotations

import os
from importlib.metadata import version

import genesis as gs
import numpy as np
from case import Case


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision = "Stomakhin 2013", "float32"

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the block of `case`; device: "cpu" or "cuda"."""
        os.environ["QD_NUM_THREADS"] = str(threads)
        self.version = version("genesis-world")
        gs.init(backend=gs.gpu if device == "cuda" else gs.cpu, precision="32", logging_level="warning")
        low, nodes = np.array(case.low), np.array(case.shape)
        scene = gs.Scene(
            sim_options=gs.options.SimOptions(dt=case.dt, substeps=1, gravity=(0.0, 0.0, case.gravity)),
            mpm_options=gs.options.MPMOptions(
                lower_bound=tuple((low * case.dx).tolist()),
                upper_bound=tuple(((low + nodes) * case.dx).tolist()),
                grid_density=1.0 / case.dx,
                particle_size=0.5 * case.dx,
            ),
            show_viewer=False,
        )
        scene.add_entity(gs.morphs.Plane(), material=gs.materials.Rigid(coup_friction=case.mu_c))
        size = np.array(case.cells) * case.dx
        self.snow = scene.add_entity(
            gs.morphs.Box(pos=(0.0, 0.0, 0.5 * float(size[2])), size=tuple(size.tolist())),
            material=gs.materials.MPM.Snow(
                E=case.E0,
                nu=case.nu,
                rho=case.rho0,
                yield_lower=case.theta_c,
                yield_higher=case.theta_s,
                sampler="regular",
            ),
        )
        scene.build()
        self.scene, self.dt, self.particles = scene, case.dt, int(self.snow.n_particles)
        self.snow.set_velocity(tuple(case.v.mean(axis=0).tolist()))

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate `seconds`, and read the particles, so that all is done."""
        steps = round(seconds / self.dt)
        for _ in range(steps):
            self.scene.step()
        self.state()
        return steps, steps * self.dt

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x, v."""
        now = self.snow.get_state()
        x, v = (np.asarray(a.cpu()).reshape(-1, 3) for a in (now.pos, now.vel))
        return x, v, None
