"""Small scenes for the tests, and the doors from a Simulation to NumPy and to the oracle."""

from dataclasses import fields

import numpy as np
from reference import contact, splines, step
from reference.snow import Snow

import neve
from neve.scene.schema.scene import Scene

ELASTIC = {"plasticity": "none"}  # snow that does not yield
NAMES = ("x", "v", "C", "modes", "F_E", "J_P", "m", "V0", "material", "stiffness", "strength", "id")


def scene(sources, colliders=(), gravity=(0.0, 0.0, 0.0), snow=None, **numerics):
    """Build a scene from tables as they stand in a TOML file.

    Numerics default to dx = 0.05 m, dt = 1e-4 s, float64, and volumes from the grid as in the paper.
    """
    return Scene.model_validate(
        {
            "world": {"gravity": gravity},
            "numerics": {"dx": 0.05, "dt": 1e-4, "precision": "float64", "initial_volume": "grid"} | numerics,
            "snow": snow or {},
            "sources": sources,
            "colliders": colliders,
        }
    )


def box(center=(0.0, 0.0, 0.0), size=(0.2, 0.2, 0.2), **more):
    return {"shape": "box", "center": center, "size": size} | more


def ball(center=(0.0, 0.0, 0.0), radius=0.15, **more):
    return {"shape": "sphere", "center": center, "radius": radius} | more


def simulate(description, threads=1):
    """Make a Simulation; on one thread, since these scenes are too small to share."""
    return neve.Simulation(description, threads=threads)


def march(sim, steps):
    """Take `steps` steps of the scene's fixed dt."""
    target = sim.steps + steps
    sim.advance(steps * sim.scene.numerics.dt)
    assert sim.steps == target
    return sim


def run(description, steps):
    return march(simulate(description), steps)


def columns(sim):
    """Copy the particles in the order of their id, in the precision of the run."""
    order = np.argsort(np.asarray(sim.state.id))
    return {name: np.array(getattr(sim.state, name))[order] for name in NAMES}


def wide(sim):
    """Copy the particles in the order of their id, as float64."""
    return {name: value.astype(float) for name, value in columns(sim).items()}


def angular_momentum(sim):
    """L = sum x cross m v + axial(m C D) [kg m2/s]; the affine part exists for affine transfers alone."""
    p, method = oracle(sim)
    return step.angular_momentum(p, method)


def oracle(sim):
    """Copy the particles of a simulation into the oracle, in the order of their id."""
    c = wide(sim)
    numerics = sim.scene.numerics
    names = [f.name for f in fields(Snow) if f.name != "strength"]
    rows = [Snow(**{name: getattr(snow, name) for name in names}) for snow in materials(sim)]
    law = Snow.table(rows, c["material"].astype(int), c["stiffness"], c["strength"])
    p = step.Particles(c["x"], c["v"], c["C"], c["F_E"], c["J_P"], c["m"], c["V0"], law, c["modes"])
    method = step.Method(
        numerics.dx, numerics.spline, numerics.transfer, numerics.flip_alpha, tuple(sim.scene.world.gravity),
        damping(sim), numerics.polypic_modes,
    )  # fmt: skip
    return p, method


def wave(snow):
    """Return the speed of pressure waves in snow that is not hardened, sqrt((lam + 2 mu) / rho0) [m/s]."""
    M_c = snow.E0 * (1 - snow.nu) / ((1 + snow.nu) * (1 - 2 * snow.nu))
    return np.sqrt(M_c / snow.rho0)


def damping(sim):
    """Return the decay rate of what the grid cannot resolve [1/s], or None if it is a share of a step."""
    numerics = sim.scene.numerics
    if numerics.transfer == "aflip":
        return numerics.aflip_damping * max(wave(snow) for snow in materials(sim)) / numerics.dx
    return None if numerics.flip_damping == "off" else numerics.flip_damping


def materials(sim):
    """Return the snow of each row of the material table."""
    rows = []
    for source in sim.scene.sources:
        snow = sim.scene.snow_of(source)
        if snow not in rows:
            rows.append(snow)
    return rows


def bodies(sim):
    """Copy the colliders at the simulation's time into the oracle."""
    out = []
    colliders = sim.scene.colliders
    for i, (solid, pose) in enumerate(sim.solids()):
        belt = np.array(colliders[i].surface_velocity if i < len(colliders) else (0.0, 0.0, 0.0))
        size = {
            "plane": lambda half: (),
            "box": lambda half: tuple(2 * half),
            "sphere": lambda half: (half[0],),
            "cylinder": lambda half: (half[0], 2 * half[2]),
        }[solid.shape](solid.half)
        parts = (np.asarray(a, float) for a in (pose.position, pose.rotation, pose.velocity, pose.omega))
        out.append(contact.Body(solid.shape, solid.mode, solid.mu_c, size, *parts, pose.rotation @ belt))
    return tuple(out)


def inertia(sim):
    """Return D / dx^2 of the spline, the part of a cell's inertia that PIC loses."""
    return splines.MOMENT[sim.scene.numerics.spline]
