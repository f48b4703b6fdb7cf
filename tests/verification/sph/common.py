"""Small scenes of smoothed particles, and their sums written out in NumPy over all pairs."""

import numpy as np
from verification.scenes import simulate

from neve import _core
from neve.scene.schema.scene import Scene

SNOW = {"rho0": 400.0, "E0": 1.4e5, "nu": 0.2, "xi": 10.0, "theta_c": 0.025, "theta_s": 0.0075}
GAMMA, PSI = 0.8, 1.5


def smoothed(sources, colliders=(), gravity=(0.0, 0.0, 0.0), snow=None, threads=1, bodies=(), **numerics):
    """Make a simulation of smoothed particles 0.05 m apart, in double precision if nothing else is said."""
    given = {"method": "sph", "dx": 0.05, "particles_per_cell": 1, "precision": "float64"} | numerics
    return simulate(
        Scene.model_validate(
            {
                "world": {"gravity": gravity},
                "numerics": given,
                "snow": snow or {},
                "sources": sources,
                "colliders": colliders,
                "bodies": bodies,
            }
        ),
        threads,
    )


def world(gravity=(0.0, 0.0, 0.0), core=_core.f64, plasticity="snow", **snow):
    """Make a model of the core with one snow."""
    model = core.Model(0.1, "quadratic", "pic", 0.0, np.array(gravity, dtype=np.float64))
    model.add_snow("stomakhin2013", plasticity, SNOW | snow)
    return model


def block(counts, spacing=0.05, jitter=0.0, seed=0, low=(0.0, 0.0, 0.0), core=_core.f64, rho0=400.0):
    """Make a lattice of particles of the core, moved at random by up to `jitter` of the spacing."""
    lattice = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(seed)
    snow = core.Sph(len(lattice), 2 * spacing)
    snow.x[...] = (lattice + jitter * (rng.random(lattice.shape) - 0.5)) * spacing + low
    snow.V0[...], snow.m[...] = spacing**3, rho0 * spacing**3
    return snow


def add_floor(snow, model, extent=0.6, mode="separate", mu_c=0.3, velocity=(0, 0, 0), spin=(0, 0, 0)):
    """Put a plane at z = 0 into the model, and a lattice of boundary particles half a spacing below it.

    velocity, spin: how it moves [m/s], and turns about the origin [1/s].
    """
    spacing = snow.support / 2
    model.add_solid("plane", np.zeros(3), mode, mu_c)
    model.place_solid(0, np.zeros(3), np.eye(3), np.array(velocity, float), np.array(spin, float))
    along = np.arange(-extent, extent + 1e-9, spacing)
    at = np.stack(np.meshgrid(along, along, indexing="ij"), axis=-1).reshape(-1, 2)
    x = np.c_[at, np.full(len(at), -spacing / 2)]
    snow.set_boundary(x, np.tile([0.0, 0.0, 1.0], (len(x), 1)), np.zeros(len(x), dtype=np.int32))


def prepare(snow, model):
    """Find what a step of any length needs."""
    snow.find_pairs(model)
    snow.find_densities(model)
    snow.correct_gradients(model)


def solve(snow, model, dt, tolerance=1e-9, most=2000):
    """Take the stages of a step up to its end; return the reports of both solves."""
    snow.find_given(model, dt)
    return snow.solve_pressure(model, dt, tolerance, 1.0, most), snow.solve_shear(dt, tolerance, most)


def kernel(x, h):
    """W and grad W at the vectors x (..., 3) of the cubic spline of support h."""
    r = np.sqrt(np.sum(x * x, axis=-1))
    q, k = r / h, 8.0 / (np.pi * h**3)
    W = k * np.where(q <= 0.5, 6 * q**3 - 6 * q**2 + 1, np.where(q < 1, 2 * (1 - q) ** 3, 0.0))
    dW = k / h * np.where(q <= 0.5, 18 * q**2 - 12 * q, np.where(q < 1, -6 * (1 - q) ** 2, 0.0))
    return W, x * np.divide(dW, r, out=np.zeros_like(r), where=r > 0)[..., None]


class Oracle:
    """The sums over all pairs of `snow` as it is, in double precision, by the equations as printed.

    gravity (3,).
    """

    def __init__(self, snow, gravity=(0.0, 0.0, 0.0), **constants):
        self.snow, self.gravity = snow, np.array(gravity)
        c = SNOW | constants
        self.x, self.v, self.F, self.m = (np.array(a) for a in (snow.x, snow.v, snow.F_E, snow.m))
        h = self.h = snow.support
        self.W, self.g = kernel(self.x[:, None] - self.x[None], h)
        self.x_b, self.v_b = np.array(snow.boundary_x), np.array(snow.boundary_v)
        self.W_b, self.g_b = kernel(self.x[:, None] - self.x_b[None], h)
        W_bb, _ = kernel(self.x_b[:, None] - self.x_b[None], h)
        self.V_b = GAMMA / W_bb.sum(axis=1)
        of_snow = self.W @ self.m
        J = np.abs(np.linalg.det(self.F))
        self.rho = of_snow / (1.0 - J * (self.W_b @ self.V_b))
        self.rho0 = J * self.rho
        self.V = self.m / self.rho
        hard = np.exp(c["xi"] * (self.rho0 - np.array(snow.rho_birth)) / self.rho0)
        self.lam = hard * c["E0"] * c["nu"] / ((1 + c["nu"]) * (1 - 2 * c["nu"]))
        self.G = hard * c["E0"] / (2 * (1 + c["nu"]))
        A = np.einsum("j,ija,ijb->iab", self.V, self.g, self.x[None] - self.x[:, None])
        self.L = np.linalg.pinv(A)

    def divergence(self, u, u_b):
        """div u of vectors of snow and boundary."""
        own = np.einsum("j,ija,ija->i", self.V, self.g, u[None] - u[:, None])
        return own + np.einsum("j,ija,ija->i", self.V_b, self.g_b, u_b[None] - u[:, None])

    def pressure_gradient(self, p):
        """grad p of equation 6."""
        own = np.einsum("j,ij,ija->ia", self.V, p[:, None] + p[None], self.g)
        return own + PSI * p[:, None] * np.einsum("j,ija->ia", self.V_b, self.g_b)

    def gradient(self, u, u_b):
        """D[u] of equations 17 and 18, L over the snow alone."""
        D_s = np.einsum("j,ija,ijb->iab", self.V, u[None] - u[:, None], self.g)
        D_b = np.einsum("j,ija,ijb->iab", self.V_b, u_b[None] - u[:, None], self.g_b)
        eye, third = np.eye(3), 1 / 3
        D = D_s @ np.swapaxes(self.L, 1, 2)
        return D + third * _trace(D_s + D_b - D)[:, None, None] * eye

    def stress_divergence(self, s, leaves=()):
        """div s: Q = tr s / 3 + dev s L on both sides. leaves: particles on which no boundary acts."""
        third = _trace(s)[:, None, None] / 3 * np.eye(3)
        Q = third + (s - third) @ self.L
        own = np.einsum("iab,j,ijb->ia", Q, self.V, self.g) + np.einsum("jab,j,ijb->ia", Q, self.V, self.g)
        walls = np.einsum("j,ijb->ib", self.V_b, self.g_b)
        walls[list(leaves)] = 0.0
        return own + _trace(s)[:, None] / 3 * walls

    def strained(self, F, u, u_b, dt):
        """(1 + dt S[u]) F, its symmetric part."""
        D = self.gradient(u, u_b)
        grown = F + dt * 0.5 * (D + np.swapaxes(D, 1, 2)) @ F
        return 0.5 * (grown + np.swapaxes(grown, 1, 2))

    def stress(self, F):
        """G (F + F^T - 2)."""
        return self.G[:, None, None] * (F + np.swapaxes(F, 1, 2) - 2 * np.eye(3))

    def friction(self, dt, mu_b, spin=(0.0, 0.0, 0.0)):
        """The acceleration of A.3, and the denominator d. spin: of the solid, whose velocity counts at x."""
        x = self.x[:, None] - self.x_b[None]
        k = mu_b * self.V_b * np.sum(x * self.g_b, axis=2) / (np.sum(x * x, axis=2) + 0.01 * self.h**2)
        d = 1 - dt * k.sum(axis=1)
        fallen = self.v + dt * self.gravity
        carried = np.einsum("ij,ija->ia", k, self.v_b[None] + np.cross(np.array(spin), x))
        return ((fallen - dt * carried) / d[:, None] - fallen) / dt, d


def _trace(a):
    return np.einsum("iaa->i", a)
