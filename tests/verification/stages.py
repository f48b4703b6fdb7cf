"""The stages of the core, one call each, on particles given as arrays: what happens below a Simulation."""

import numpy as np
from verification.material import DEFAULT, parameters

from neve import _core


class Lab:
    """A model, a state and a grid of one precision, with the particles' arrays copied in."""

    def __init__(
        self,
        core,
        precision,
        spline,
        transfer,
        laws=(DEFAULT,),
        dx=0.05,
        alpha=0.95,
        gravity=(0, 0, 0),
        polypic_modes=8,
        flip_damping=None,
        **values,
    ):
        _core.set_threads(1)
        self.core, self.dtype = core, np.dtype(precision)
        self.model = core.Model(
            dx, spline, transfer, alpha, np.asarray(gravity, float), polypic_modes, flip_damping
        )
        for law in laws:
            self.model.add_snow(str(law.law), str(law.plasticity), parameters(law))
        self.state = core.State(len(values["x"]), self.model.more_modes)
        self.grid = core.Grid()
        for name, value in values.items():
            getattr(self.state, name)[:] = np.asarray(value).astype(getattr(self.state, name).dtype)

    def add_body(self, body):
        """Add a collider of the oracle."""
        half = np.zeros(3)
        if body.shape == "box":
            half[:] = np.asarray(body.size) / 2
        elif body.shape == "sphere":
            half[0] = body.size[0]
        elif body.shape == "cylinder":
            half[0], half[2] = body.size[0], body.size[1] / 2
        self.model.add_solid(body.shape, half, body.mode, body.mu_c)
        if self.state.modes.shape[1] != self.model.more_modes:
            self.make_room()
        place = (body.position, body.rotation, body.velocity, body.omega)
        index = self.solids = getattr(self, "solids", -1) + 1
        self.model.place_solid(index, *(np.ascontiguousarray(a, dtype=float) for a in place))
        self.model.set_belt(index, np.ascontiguousarray(body.belt, dtype=float))

    def make_room(self):
        """Give the particles the columns that a surface with play needs."""
        old, self.state = self.state, self.core.State(self.state.count, self.model.more_modes)
        self.state.modes[:, : old.modes.shape[1]] = old.modes
        for name in ("x", "v", "C", "F_E", "J_P", "m", "V0", "stiffness", "strength", "material", "id"):
            getattr(self.state, name)[:] = getattr(old, name)

    def p2g(self, dt):
        self.core.refresh(self.model, self.state)
        self.core.sort(self.model, self.state, self.grid)
        self.core.p2g(self.model, self.state, self.grid, dt)

    def grid_update(self, dt):
        self.core.grid_update(self.model, self.grid, dt)

    def g2p(self, dt):
        return self.core.g2p(self.model, self.state, self.grid, dt)

    def step(self, dt):
        self.p2g(dt)
        self.grid_update(dt)
        return self.g2p(dt)

    def columns(self):
        """Copy the particles in the order of their id, as float64."""
        order = np.argsort(np.asarray(self.state.id))
        names = ("x", "v", "C", "modes", "F_E", "J_P", "m", "V0", "tau")
        return {name: np.array(getattr(self.state, name), float)[order] for name in names}
