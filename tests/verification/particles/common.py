"""Small scenes of particles in contact."""

import numpy as np
from verification.scenes import simulate

from neve.scene.schema.scene import Scene

NAMES = ("x", "v", "m", "V0", "radius", "J_P", "stiffness", "strength", "material", "source", "id")


def particles(sources, colliders=(), gravity=(0.0, 0.0, 0.0), snow=None, threads=1, more=None, **numerics):
    """Make a simulation of particles, in double precision with 0.05 m if nothing else is said.

    more: further tables of the scene.
    """
    given = {"method": "particles", "dx": 0.05, "precision": "float64"} | numerics
    return simulate(
        Scene.model_validate(
            {
                "world": {"gravity": gravity},
                "numerics": given,
                "snow": snow or {},
                "sources": sources,
                "colliders": colliders,
            }
            | (more or {})
        ),
        threads,
    )


def columns(sim):
    """Copy the particles in the order of their id."""
    order = np.argsort(np.asarray(sim.state.id))
    return {name: np.array(getattr(sim.state, name))[order] for name in NAMES}


def energy(sim):
    """Return the energy of the snow less the work of the colliders [J]."""
    d = sim.diagnostics()
    return d.kinetic + d.elastic + d.potential - d.work


def pair_of_particles(gap, speed=0.0, snow=None, bonded=False):
    """Make two particles on the x axis that are `gap` of their diameter apart and part with `speed` [m/s].

    Returns the simulation and the radius [m].
    """
    sim = particles([{"shape": "box", "size": (0.05, 0.05, 0.025)}], snow=snow, particles_per_cell=8, dt=1e-5)
    state = sim.state
    r = float(state.radius[0])
    n = sim.count
    far = 1e3 * np.arange(n)  # the others are out of the way
    state.x[...] = 0.0
    state.x[:, 1] = far
    state.id[...] = np.arange(n, dtype=np.uint32)
    state.x[1] = (2 * r * (1 + gap), 0, 0)
    state.v[...] = 0.0
    state.v[0, 0], state.v[1, 0] = -speed / 2, speed / 2
    begin = np.zeros(n + 1, dtype=np.uint32)
    state.set_contacts(sim.solver._near, begin, np.zeros(0, dtype=np.int32), np.zeros((0, 4)))
    if bonded:
        sim.solver._bond(0)
    return sim, r
