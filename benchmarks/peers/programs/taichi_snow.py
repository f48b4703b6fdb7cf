"""The explicit snow substep as a good Taichi user writes it: the peer that Neve is measured against.

Same step as Neve's default (MLS-APIC, quadratic B-spline, float32): return map and Kirchhoff stress per
particle (fixed-corotated energy, clamp of the singular values, hardening: Stomakhin et al. 2013, sections
4-6), scatter to a dense grid, gravity, contact with the ground on nodes and particles, gather. Taichi's own
means throughout: `ti.svd`, static unrolling over the 27 nodes, automatic atomics, all threads, fast_math.
"""

# Annotations are not postponed: Taichi reads them.

import importlib
import os
from importlib.metadata import version

import numpy as np
from case import J_P_BOUNDS, Case

LANGUAGE = os.environ.get("SNOW_LANGUAGE", "taichi")  # or its fork, "quadrants"
ti = importlib.import_module(LANGUAGE)


@ti.data_oriented
class TaichiSnow:
    """Run the explicit snow substep on a dense grid with Taichi on all CPU threads."""

    def __init__(self, case: Case) -> None:
        """Copy the particles into Taichi fields, in the order of the grid's rows, which suits the cache."""
        order = case.by_rows()
        self.n = len(case.x)
        self.dx, self.dt, self.inv_dx = case.dx, case.dt, 1.0 / case.dx
        self.mu0 = case.E0 / (2 * (1 + case.nu))
        self.lam0 = case.E0 * case.nu / ((1 + case.nu) * (1 - 2 * case.nu))
        self.xi, self.sigma_min, self.sigma_max = case.xi, 1 - case.theta_c, 1 + case.theta_s
        self.gravity, self.mu_c = case.gravity, case.mu_c
        self.low = ti.Vector([int(i) for i in case.low])

        self.x = ti.Vector.field(3, ti.f32, self.n)
        self.v = ti.Vector.field(3, ti.f32, self.n)
        self.C = ti.Matrix.field(3, 3, ti.f32, self.n)
        self.F_E = ti.Matrix.field(3, 3, ti.f32, self.n)
        self.J_P = ti.field(ti.f32, self.n)
        self.finished = ti.field(ti.f32, self.n)
        self.m = ti.field(ti.f32, self.n)
        self.V0 = ti.field(ti.f32, self.n)
        self.grid_v = ti.Vector.field(3, ti.f32, case.shape)  # momentum, then velocity
        self.grid_m = ti.field(ti.f32, case.shape)

        self.x.from_numpy(case.x[order].astype(np.float32))
        self.v.from_numpy(case.v[order].astype(np.float32))
        self.m.from_numpy(case.m[order].astype(np.float32))
        self.V0.from_numpy(case.V0[order].astype(np.float32))
        self.F_E.from_numpy(np.broadcast_to(np.eye(3, dtype=np.float32), (self.n, 3, 3)).copy())
        self.J_P.fill(1)

    def advance(self, steps: int) -> None:
        """Take `steps` substeps and wait for them."""
        for _ in range(steps):
            self.clear()
            self.p2g()
            self.grid_update()
            self.g2p()
        ti.sync()

    def flowed(self) -> np.ndarray:
        """Return J_P (n,) with the flow of the last step, which the next `p2g` would begin with."""
        self.finish()
        return self.finished.to_numpy()

    @ti.kernel
    def finish(self):
        for p in self.x:
            _, _, _, self.finished[p] = self.flow(p)

    @ti.kernel
    def clear(self):
        for i in ti.grouped(self.grid_m):
            self.grid_v[i] = ti.Vector.zero(ti.f32, 3)
            self.grid_m[i] = 0

    @ti.func
    def flow(self, p):
        """Deform particle p by its C, clamp the stretches: the SVD of F_E, and J_P."""
        U, sig, V = ti.svd((ti.Matrix.identity(ti.f32, 3) + self.dt * self.C[p]) @ self.F_E[p])
        J_P = self.J_P[p]
        for d in ti.static(range(3)):
            s = ti.min(ti.max(sig[d, d], self.sigma_min), self.sigma_max)
            J_P *= sig[d, d] / s
            sig[d, d] = s
        return U, sig, V, J_P

    @ti.kernel
    def p2g(self):
        for p in self.x:
            u = self.x[p] * self.inv_dx
            base = ti.floor(u - 0.5, ti.i32)
            fx = u - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]

            U, sig, V, J_P = self.flow(p)
            F_E = U @ sig @ V.transpose()
            J = sig[0, 0] * sig[1, 1] * sig[2, 2]
            self.F_E[p], self.J_P[p] = F_E, J_P
            h = ti.exp(self.xi * (1 - ti.min(ti.max(J_P, J_P_BOUNDS[0]), J_P_BOUNDS[1])))
            tau = 2 * self.mu0 * h * (F_E - U @ V.transpose()) @ F_E.transpose()
            tau += ti.Matrix.identity(ti.f32, 3) * self.lam0 * h * J * (J - 1)

            m = self.m[p]
            affine = m * self.C[p] - (4 * self.dt * self.inv_dx**2) * self.V0[p] * tau
            node = base - self.low
            for o in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                w_ip = w[o[0]][0] * w[o[1]][1] * w[o[2]][2]
                self.grid_v[node + o] += w_ip * (m * self.v[p] + affine @ ((o - fx) * self.dx))
                self.grid_m[node + o] += w_ip * m

    @ti.func
    def contact(self, v):
        """Respond to the ground below: no approach, Coulomb friction on what slides."""
        if v.z < 0:
            v_t = ti.Vector([v.x, v.y, 0.0])
            slip = v_t.norm()
            v = v_t * ti.max(0.0, 1 + self.mu_c * v.z / ti.max(slip, 1e-12))
        return v

    @ti.kernel
    def grid_update(self):
        for i in ti.grouped(self.grid_m):
            if self.grid_m[i] > 0:
                v = self.grid_v[i] / self.grid_m[i]
                v.z += self.dt * self.gravity
                if i.z + self.low.z <= 0:
                    v = self.contact(v)
                self.grid_v[i] = v

    @ti.kernel
    def g2p(self):
        for p in self.x:
            u = self.x[p] * self.inv_dx
            base = ti.floor(u - 0.5, ti.i32)
            fx = u - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1) ** 2, 0.5 * (fx - 0.5) ** 2]
            v = ti.Vector.zero(ti.f32, 3)
            C = ti.Matrix.zero(ti.f32, 3, 3)
            node = base - self.low
            for o in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                w_ip = w[o[0]][0] * w[o[1]][1] * w[o[2]][2]
                v_i = self.grid_v[node + o]
                v += w_ip * v_i
                C += (4 * self.inv_dx * w_ip) * v_i.outer_product(o - fx)
            if self.x[p].z + self.dt * v.z <= 0:
                v = self.contact(v)
            self.v[p], self.C[p] = v, C
            self.x[p] += self.dt * v


class Program:
    """The snow, as `worker.py` runs it (see `neve_snow.py`)."""

    law, precision = "Stomakhin 2013", "float32"

    def __init__(self, case: Case, threads: int, device: str) -> None:
        """Take the particles of `case`; device: "cpu" or "cuda"."""
        arch = ti.cuda if device == "cuda" else ti.cpu
        ti.init(arch=arch, log_level=ti.WARN, cpu_max_num_threads=threads)
        self.version = version(LANGUAGE)
        self.snow = TaichiSnow(case)
        self.dt, self.particles = case.dt, self.snow.n

    def advance(self, seconds: float) -> tuple[int, float]:
        """Simulate `seconds`."""
        steps = round(seconds / self.dt)
        self.snow.advance(steps)
        return steps, steps * self.dt

    def state(self) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return x, v, J_P."""
        return self.snow.x.to_numpy(), self.snow.v.to_numpy(), self.snow.flowed()
