"""The explicit snow substep as a Warp user writes it, with our own kernels: a second peer.

The same step as in taichi_snow.py: MLS-APIC, quadratic B-spline, float32, fixed-corotated stress with
hardening and clamped stretches (Stomakhin et al. 2013, sections 4-6), a dense grid, ground contact on nodes
and particles. Warp's own means: `wp.svd3`, vectors and matrices, `wp.atomic_add`; on a GPU the launches of a
step are recorded in a CUDA graph.
"""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np
import warp as wp
from case import J_P_BOUNDS, Case

J_P_LOW, J_P_HIGH = wp.constant(J_P_BOUNDS[0]), wp.constant(J_P_BOUNDS[1])


@wp.struct
class Constants:
    """What all kernels are given."""

    dx: float
    inv_dx: float
    dt: float
    mu0: float
    lam0: float
    xi: float
    sigma_min: float
    sigma_max: float
    gravity: float
    mu_c: float
    low: wp.vec3i


@wp.func
def weight(offset: int, fx: float):
    """Weight of node 0, 1 or 2 for a particle at fx cells from node 0."""
    if offset == 0:
        return 0.5 * (1.5 - fx) * (1.5 - fx)
    if offset == 1:
        return 0.75 - (fx - 1.0) * (fx - 1.0)
    return 0.5 * (fx - 0.5) * (fx - 0.5)


@wp.func
def contact(v: wp.vec3, mu_c: float):
    """Respond to the ground below: no approach, Coulomb friction on what slides."""
    if v[2] >= 0.0:
        return v
    v_t = wp.vec3(v[0], v[1], 0.0)
    return v_t * wp.max(0.0, 1.0 + mu_c * v[2] / wp.max(wp.length(v_t), 1.0e-12))


@wp.kernel
def flow(c: Constants, C: wp.array(dtype=wp.mat33), F_E: wp.array(dtype=wp.mat33), J_P: wp.array(dtype=float),
         tau: wp.array(dtype=wp.mat33)):  # fmt: skip
    """Deform by C, clamp the stretches, and derive the Kirchhoff stress."""
    p = wp.tid()
    one = wp.identity(n=3, dtype=float)
    U = wp.mat33()
    sig = wp.vec3()
    V = wp.mat33()
    wp.svd3((one + c.dt * C[p]) * F_E[p], U, sig, V)
    clamped = wp.vec3()
    flowed = J_P[p]
    for d in range(3):
        clamped[d] = wp.clamp(sig[d], c.sigma_min, c.sigma_max)
        flowed = flowed * sig[d] / clamped[d]
    F = U * wp.diag(clamped) * wp.transpose(V)
    J = clamped[0] * clamped[1] * clamped[2]
    h = wp.exp(c.xi * (1.0 - wp.clamp(flowed, J_P_LOW, J_P_HIGH)))
    F_E[p] = F
    J_P[p] = flowed
    tau[p] = 2.0 * c.mu0 * h * (F - U * wp.transpose(V)) * wp.transpose(F) + one * (
        c.lam0 * h * J * (J - 1.0)
    )


@wp.kernel
def p2g(c: Constants, x: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), C: wp.array(dtype=wp.mat33),
        tau: wp.array(dtype=wp.mat33), m: wp.array(dtype=float), V0: wp.array(dtype=float),
        node: wp.array3d(dtype=wp.vec4)):  # fmt: skip
    """Scatter mass, momentum and force."""
    p = wp.tid()
    u = x[p] * c.inv_dx
    b = wp.vec3i(int(wp.floor(u[0] - 0.5)), int(wp.floor(u[1] - 0.5)), int(wp.floor(u[2] - 0.5)))
    fx = u - wp.vec3(float(b[0]), float(b[1]), float(b[2]))
    affine = m[p] * C[p] - (4.0 * c.dt * c.inv_dx * c.inv_dx * V0[p]) * tau[p]
    for i in range(3):
        for j in range(3):
            for k in range(3):
                w = weight(i, fx[0]) * weight(j, fx[1]) * weight(k, fx[2])
                arm = (wp.vec3(float(i), float(j), float(k)) - fx) * c.dx
                q = w * (m[p] * v[p] + affine * arm)
                at = b - c.low
                wp.atomic_add(node, at[0] + i, at[1] + j, at[2] + k, wp.vec4(q[0], q[1], q[2], w * m[p]))


@wp.kernel
def grid_update(c: Constants, node: wp.array3d(dtype=wp.vec4)):
    """Momenta become velocities; gravity, and the ground."""
    i, j, k = wp.tid()
    q = node[i, j, k]
    if q[3] > 0.0:
        v = wp.vec3(q[0], q[1], q[2]) / q[3]
        v = wp.vec3(v[0], v[1], v[2] + c.dt * c.gravity)
        if k + c.low[2] <= 0:
            v = contact(v, c.mu_c)
        node[i, j, k] = wp.vec4(v[0], v[1], v[2], q[3])


@wp.kernel
def g2p(c: Constants, x: wp.array(dtype=wp.vec3), v: wp.array(dtype=wp.vec3), C: wp.array(dtype=wp.mat33),
        node: wp.array3d(dtype=wp.vec4)):  # fmt: skip
    """Gather velocity and its gradient, and move."""
    p = wp.tid()
    u = x[p] * c.inv_dx
    b = wp.vec3i(int(wp.floor(u[0] - 0.5)), int(wp.floor(u[1] - 0.5)), int(wp.floor(u[2] - 0.5)))
    fx = u - wp.vec3(float(b[0]), float(b[1]), float(b[2]))
    new_v = wp.vec3()
    new_C = wp.mat33()
    for i in range(3):
        for j in range(3):
            for k in range(3):
                w = weight(i, fx[0]) * weight(j, fx[1]) * weight(k, fx[2])
                at = b - c.low
                q = node[at[0] + i, at[1] + j, at[2] + k]
                v_i = wp.vec3(q[0], q[1], q[2])
                new_v = new_v + w * v_i
                new_C = new_C + (4.0 * c.inv_dx * w) * wp.outer(
                    v_i, wp.vec3(float(i), float(j), float(k)) - fx
                )
    if x[p][2] + c.dt * new_v[2] <= 0.0:
        new_v = contact(new_v, c.mu_c)
    v[p] = new_v
    C[p] = new_C
    x[p] = x[p] + c.dt * new_v


class WarpSnow:
    """Run the explicit snow substep on a dense grid with Warp."""

    def __init__(self, case: Case, device: str) -> None:
        """Copy the particles, in the order of the grid's rows; device: "cuda" or "cpu"."""
        order = case.by_rows()
        self.n, self.device, self._graph = len(case.x), device, None

        def array(values: Any, kind: Any) -> Any:
            return wp.array(np.ascontiguousarray(values, np.float32), dtype=kind, device=device)

        self.x, self.v = array(case.x[order], wp.vec3), array(case.v[order], wp.vec3)
        self.m, self.V0 = array(case.m[order], float), array(case.V0[order], float)
        self.F_E = array(np.broadcast_to(np.eye(3), (self.n, 3, 3)), wp.mat33)
        self.J_P = array(np.ones(self.n), float)
        self.C, self.tau = (wp.zeros(self.n, dtype=wp.mat33, device=device) for _ in range(2))
        self.node = wp.zeros(case.shape, dtype=wp.vec4, device=device)
        c = self.constants = Constants()
        c.dx, c.inv_dx, c.dt = case.dx, 1.0 / case.dx, case.dt
        c.mu0 = case.E0 / (2 * (1 + case.nu))
        c.lam0 = case.E0 * case.nu / ((1 + case.nu) * (1 - 2 * case.nu))
        c.xi, c.sigma_min, c.sigma_max = case.xi, 1 - case.theta_c, 1 + case.theta_s
        c.gravity, c.mu_c, c.low = case.gravity, case.mu_c, wp.vec3i(*(int(i) for i in case.low))

    def advance(self, steps: int) -> None:
        """Take `steps` substeps and wait for them."""
        if self._graph is None and self.device != "cpu":
            self._step()  # modules are loaded
            with wp.ScopedCapture(device=self.device) as capture:
                self._step()
            self._graph = capture.graph
            steps -= 1  # what is recorded is not run
        for _ in range(steps):
            if self._graph is None:
                self._step()
            else:
                wp.capture_launch(self._graph)
        wp.synchronize_device(self.device)

    def _step(self) -> None:
        self.node.zero_()
        c, n, device = self.constants, self.n, self.device
        wp.launch(flow, n, [c, self.C, self.F_E, self.J_P, self.tau], device=device)
        state = [self.x, self.v, self.C]
        wp.launch(p2g, n, [c, *state, self.tau, self.m, self.V0, self.node], device=device)
        wp.launch(grid_update, self.node.shape, [c, self.node], device=device)
        wp.launch(g2p, n, [c, *state, self.node], device=device)

    def flowed(self) -> np.ndarray:
        """Return J_P (n,) with the flow of the last step, which the next `flow` would begin with."""
        F_E, J_P, tau = (wp.clone(a) for a in (self.F_E, self.J_P, self.tau))
        wp.launch(flow, self.n, [self.constants, self.C, F_E, J_P, tau], device=self.device)
        return J_P.numpy()


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision = "Stomakhin 2013", "float32"

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`; device: "cpu" or "cuda". On a processor Warp has one thread."""
        self.version = version("warp-lang")
        self.snow = WarpSnow(case, device)
        self.dt, self.particles = case.dt, self.snow.n

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate `seconds`."""
        steps = round(seconds / self.dt)
        self.snow.advance(steps)
        return steps, steps * self.dt

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x, v, J_P."""
        return self.snow.x.numpy(), self.snow.v.numpy(), self.snow.flowed()
