"""The longitudinal vibration of an elastic bar: one end fixed, one free (known answer 16)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.values.choices import TRANSFERS
from neve.validate.result import Check, Curve, Plot, Result, band, near
from neve.validate.scenes import box, column, duct, elastic, moduli, simulation, transfers

Array = NDArray[np.float64]

E0, NU, RHO = 1.4e5, 0.2, 400.0
LENGTH = 1.0
"""From the fixed end to the free one [m]."""
STRAIN = 1e-5
"""Largest strain: so small that the law's curvature, of that order, is below every other error."""
CFL = 0.4


@dataclass(frozen=True)
class Vibration:
    """Hold a vibrating bar at the times t [s], after each step.

    Attributes:
        t: times [s]; leapfrog velocities belong to t - dt / 2
        amplitude: of the first mode in the displacement over the exact amplitude v0 / omega [1]
        speed: of the first mode in the velocity over v0 [1]
        energy: kinetic and elastic energy over the initial kinetic energy [1]; the kinetic one is the mean of
            those half a step before and after
        omega: exact angular frequency [rad/s]
        error: root mean square error of the displacement at the end over the exact amplitude [1]
        dt, h: time step [s], edge of a cell [m]
        particles: how many
    """

    t: Array
    amplitude: Array
    speed: Array
    energy: Array
    omega: float
    error: float
    dt: float
    h: float
    particles: int

    def drift(self) -> float:
        """Return the change of the energy in a period, as a share of it, from first to last."""
        first = int(np.searchsorted(self.t, self.period * (1 + 1e-6))) - 1
        return float(
            (self.energy[-1] / self.energy[first]) ** (self.period / (self.t[-1] - self.t[first])) - 1
        )

    @property
    def period(self) -> float:
        """Exact period [s]."""
        return float(2 * np.pi / self.omega)

    def measured_period(self) -> float:
        """Return the period [s] from the zeros of the displacement, found by straight lines between steps."""
        u, t = self.amplitude, self.t
        k = np.flatnonzero(u[1:] * u[:-1] < 0)
        zeros = t[k] - u[k] * (t[k + 1] - t[k]) / (u[k + 1] - u[k])
        return float(2 * (zeros[-1] - zeros[0]) / (len(zeros) - 1))

    def peaks(self) -> tuple[Array, Array]:
        """Return the times [s] and heights of the extremes of the displacement, in size."""
        u = np.abs(self.amplitude)
        k = np.flatnonzero((u[1:-1] >= u[:-2]) & (u[1:-1] > u[2:])) + 1
        return self.t[k], u[k]


def vibrate(
    cells: int = 20,
    periods: float = 2.0,
    slender: int = 0,
    law: str = "stomakhin2013",
    courant: float = CFL,
    **numerics: Any,
) -> Vibration:
    """Let a bar of `cells` cells from its fixed to its free end vibrate in its first mode.

    The bar is one half of a bar of twice the length with two free ends and a velocity that is odd about the
    middle: the middle stays where it is, to the bit of a sum, and no wall has a say. It fills a smooth duct
    of one cell by one (uniaxial strain), or is free at its sides and `slender` cells thick (uniaxial stress).
    courant: cells that a wave crosses in a step, or a little less.

    v^0 = v0 cos(omega dt / 2) sin(k z): in symplectic Euler the velocity v^n stands at t_n - dt / 2.
    """
    h = LENGTH / cells
    modulus = E0 if slender else moduli(E0, NU)[2]
    omega = 0.5 * np.pi / LENGTH * np.sqrt(modulus / RHO)
    steps_per_period = int(np.ceil(4 * LENGTH / (courant * h) * np.sqrt(moduli(E0, NU)[2] / modulus)))
    dt = 2 * np.pi / omega / steps_per_period
    thick = 0.5 * h * (slender or 1)
    low, high = (-thick, -thick, -LENGTH), (thick, thick, LENGTH)
    walls = []
    if not slender:
        low, high, walls = (0.0, 0.0, -LENGTH), (h, h, LENGTH), duct(h, h)
    sim = simulation(
        [box(low, high)],
        walls,
        snow=elastic(law=law, E0=E0, nu=NU, rho0=RHO),
        dx=h,
        dt=float(dt),
        **numerics,
    )
    return _march(sim, omega, dt, round(periods * steps_per_period))


def _march(sim: Any, omega: float, dt: float, steps: int) -> Vibration:
    k = 0.5 * np.pi / LENGTH
    v0 = STRAIN * omega / k
    z = np.asarray(sim.state.x)[:, 2]
    sim.state.v[:, 2] = v0 * np.cos(0.5 * omega * dt) * np.sin(k * z)
    if TRANSFERS[sim.scene.numerics.transfer].keeps_C:
        sim.state.C[:, 2, 2] = v0 * np.cos(0.5 * omega * dt) * k * np.cos(k * z)
    start = column(sim, "x")[:, 2]
    m = column(sim, "m")
    shape = np.sin(k * start)
    weight = m * shape / (m * shape**2).sum()
    kinetic = sim.diagnostics().kinetic
    history = []
    for _ in range(steps):
        sim.advance(dt)
        d = sim.diagnostics()
        u, v = column(sim, "x")[:, 2] - start, column(sim, "v")[:, 2]
        history.append((weight @ u * omega / v0, weight @ v / v0, d.kinetic / kinetic, d.elastic / kinetic))
    t: Array = dt * np.arange(1, steps + 1, dtype=np.float64)
    exact = np.sin(omega * t[-1]) * shape
    error = np.sqrt(np.mean((u * omega / v0 - exact) ** 2))
    a, s, k, e = np.array(history).T
    e = e + 0.5 * (k + np.append(k[1:], 2 * k[-1] - k[-2]))
    return Vibration(
        t, a, s, e, float(omega), float(error), float(dt), float(sim.scene.numerics.dx), int(sim.state.count)
    )


def pic_decay(v: Vibration, moment: float = 0.25) -> float:
    """Return the share of energy that PIC leaves after a period [1]: exp(-k^2 D N), N steps in a period.

    One way from particles to grid smooths with the spline, whose second moment is D (`moment` h^2 = h^2 / 4
    for quadratic, h^2 / 3 for cubic), and so does the way back: each wave of the wave number k loses the
    share k^2 D of its velocity in a step, and an oscillation half of that in its amplitude.
    """
    k, h = 0.5 * np.pi / LENGTH, v.h
    return float(np.exp(-(k**2) * moment * h**2 * v.period / v.dt))


def case(cells: int = 20, periods: float = 3.0) -> Result:
    """Measure the period and the energy of the bar, with every transfer."""
    runs = {name: vibrate(cells, periods, **how) for name, how in transfers().items()}
    cubic = vibrate(cells, periods, spline="cubic")
    thin = vibrate(cells, 1.6, slender=4)
    return Result(
        what=f"An elastic bar of {cells} cells, fixed at one end, free at the other, vibrates in its "
        f"first mode. "
        "The fixed end is the middle of a bar of twice the length that moves oddly, so no wall takes part. "
        "Its "
        "sides are held by smooth walls (uniaxial strain) or are free (uniaxial stress).",
        equations=(
            "<i>u</i> = (<i>v</i><sub>0</sub>/<i>&omega;</i>) sin(<i>&pi;z</i>/2<i>L</i>) sin "
            "<i>&omega;t</i>",
            "<i>&omega;</i> = (<i>&pi;</i>/2<i>L</i>) &radic;(<i>M</i><sub>c</sub>/<i>&rho;</i>), "
            "or &radic;(<i>E</i>/<i>&rho;</i>) with free sides",
        ),
        source="Linear elastic waves; strains stay below 10<sup>&minus;5</sup>. The damping of PIC is our "
        "own "
        "derivation from the spline's second moment.",
        checks=_checks(runs, cubic, thin),
        plots=_plots(runs),
        verdict="Every transfer but PIC keeps the period and the energy of a vibration; PIC damps it, and by "
        "as much as the theory of its two smoothings says.",
        particles=sum(r.particles for r in (*runs.values(), cubic, thin)),
        steps=sum(len(r.t) for r in (*runs.values(), cubic, thin)),
    )


def _period(name: str, v: Vibration) -> Check:
    reason = "L/h &ge; 20: the grid's dispersion is (kh)<sup>2</sup>/4 &lt; 0.2 %; 2 % is required of Neve"
    return near(f"{name}: period", v.measured_period(), v.period, 0.02, reason, "s")


def _drift(name: str, v: Vibration) -> Check:
    reason = "damping of fourth order in kh, oscillation of symplectic Euler; 1 % is required of Neve"
    return Check(f"{name}: change of energy in a period", v.drift(), 0.0, 0.01, reason)


def _checks(runs: dict[str, Vibration], cubic: Vibration, thin: Vibration) -> tuple[Check, ...]:
    checks = [_period("apic, uniaxial strain", runs["apic"]), _period("apic, cubic spline", cubic)]
    checks.append(_period("apic, uniaxial stress (free sides)", thin))
    for name, r in runs.items():
        if TRANSFERS[name].damps:
            reason = (
                "known answer exp(-k<sup>2</sup> h<sup>2</sup> N / 4) for N steps; terms in h<sup>4</sup>"
            )
            checks.append(near("pic, energy left after a period", 1 + r.drift(), pic_decay(r), 0.03, reason))
        else:
            checks.append(_period(name, r) if name != "apic" else _drift(name, r))
            checks.extend([_drift(name, r)] if name != "apic" else [])
    return tuple(checks)


def _plots(runs: dict[str, Vibration]) -> tuple[Plot, ...]:
    v, T = runs["apic"], runs["apic"].period
    exact = np.sin(v.omega * v.t)
    shown = slice(None, None, max(1, len(v.t) // 50))
    return (
        Plot(
            "The free end swings",
            "time over exact period [1]",
            "displacement over amplitude [1]",
            (
                band("exact, 2 % of the period either way", v.t / T, exact, 0.02 * 2 * np.pi * v.t / T),
                *(Curve(name, r.t[shown] / T, r.amplitude[shown]) for name, r in runs.items()),
            ),
        ),
        Plot(
            "Energy",
            "time over exact period [1]",
            "energy over energy at the start [1]",
            (
                band("1 % in a period", v.t / T, np.ones_like(v.t), 0.01 * v.t / T),
                *(Curve(name, r.t / T, r.energy) for name, r in runs.items()),
                Curve("PIC in theory", v.t / T, pic_decay(v) ** (v.t / T), "other"),
            ),
        ),
    )
