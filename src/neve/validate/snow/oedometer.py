"""Snow in a rigid ring under a falling piston: the oedometer of soil mechanics (known answer 13)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.validate.result import Curve, Plot, Result, band, near
from neve.validate.scenes import box, column, duct, moduli, plane, simulation, stress

Array = NDArray[np.float64]

E0, NU, XI, THETA_C, RHO = 1.4e5, 0.2, 10.0, 2.5e-2, 400.0


def answer(s: Array) -> tuple[Array, Array]:
    """Return the Cauchy stresses sigma_33 and sigma_11 [Pa] of default snow at the height s of its first.

    Elastic for s >= 1 - theta_c: tau_33 = M_c (s - 1) s, tau_11 = lam (s - 1) s. Below, the elastic stretch
    stays at 1 - theta_c and J_P = s / (1 - theta_c) hardens: both are multiplied by exp(xi (1 - J_P)).
    """
    _, lam, M_c = moduli(E0, NU)
    k = np.maximum(s, 1 - THETA_C)
    hardening = np.exp(XI * (1 - s / k)) * (k - 1) * k / s
    return hardening * M_c, hardening * lam


@dataclass(frozen=True)
class Compression:
    """Hold a compression: height s [1], Cauchy stresses [Pa] and density [kg/m3], means over the middle half.

    J_P [1] is the mean plastic volume change.
    """

    s: Array
    axial: Array
    sideways: Array
    J_P: Array
    particles: int
    steps: int


def compress(
    cells: int = 16,
    last: float = 0.6,
    rate: float = 2.0,
    points: int = 80,
    snow: dict[str, Any] | None = None,
    **numerics: Any,
) -> Compression:
    """Press a column of snow to `last` of its height [1], by `rate` of its height a second [1/s].

    The snow starts with the velocity -rate z of even compression, which meets the piston's, so that nothing
    has to be accelerated: z = (1 - rate t) Z solves the equations of motion exactly.
    """
    height = 0.4
    h = height / cells
    sim = simulation(
        [box((0, 0, 0), (h, h, height))],
        [
            *duct(h, h),
            plane((0, 0, 0), (0, 0, 1)),
            plane((0, 0, height), (0, 0, -1), velocity=[0.0, 0.0, -rate * height]),
        ],
        snow=snow,
        dx=h,
        **numerics,
    )
    z = column(sim, "x")[:, 2]
    middle = np.abs(z / height - 0.5) < 0.25
    sim.state.v[:, 2] = -rate * np.asarray(sim.state.x)[:, 2]
    sim.state.C[:, 2, 2] = -rate
    rows = []
    low, high = np.flatnonzero(middle)[[np.argmin(z[middle]), np.argmax(z[middle])]]
    for s in np.linspace(1, last, points + 1)[1:]:
        sim.advance((1 - s) / rate - sim.time)
        x = column(sim, "x")[:, 2]
        local = (x[high] - x[low]) / (z[high] - z[low])
        tau = stress(sim)[middle].mean(0) / local
        rows.append((local, tau[2, 2], tau[0, 0], column(sim, "J_P")[middle].mean()))
    s, axial, sideways, J_P = np.array(rows).T
    return Compression(s, axial, sideways, J_P, int(sim.state.count), sim.steps)


MARKS = (0.99, 0.975, 0.95, 0.9, 0.8, 0.7, 0.62)


def case(cells: int = 16) -> Result:
    """Measure the stress of default snow down to six tenths of its height."""
    r = compress(cells, last=0.57)
    keep = r.s >= 0.6
    s, axial, sideways = r.s[keep], r.axial[keep], r.sideways[keep]
    exact, exact_side = answer(s)
    reason = "3 % for snow in motion is required of Neve: waves from the piston, and particles that "
    "meet walls"
    checks = []
    for mark in MARKS:
        k = int(np.argmin(np.abs(s - mark)))
        checks.append(near(f"axial stress at s = {s[k]:.3f}", axial[k], exact[k], 0.03, reason, "Pa"))
    worst = int(np.argmax(np.abs(sideways / exact_side - 1)))
    checks.append(
        near(
            f"sideways stress at s = {s[worst]:.3f}, its worst",
            sideways[worst],
            exact_side[worst],
            0.03,
            reason,
            "Pa",
        )
    )
    plots = (
        Plot(
            "Compression of default snow",
            "height over first height, s [1]",
            "pressure [Pa]",
            (
                band("exact, 3 %", s, -exact, -0.03 * exact),
                Curve("axial", s[::2], -axial[::2]),
                band("", s, -exact_side, -0.03 * exact_side),
                Curve("sideways", s[::2], -sideways[::2]),
            ),
            y_scale="log",
        ),
    )
    return Result(
        what=f"Default snow ({cells} cells high) in a smooth duct is compressed by a piston at two "
        f"heights a second. "
        "s is the height of the middle half over its first height, from the places of its particles; the "
        "stress is the mean over that half.",
        equations=(
            "<i>s</i> &ge; 1 &minus; <i>&theta;</i><sub>c</sub>: <i>&tau;</i><sub>33</sub> = "
            "<i>M</i><sub>c</sub>(<i>s</i> &minus; 1)<i>s</i>, <i>&tau;</i><sub>11</sub> = <i>&lambda;</i>"
            "(<i>s</i> &minus; 1)<i>s</i>",
            "below: <i>J</i><sub>P</sub> = <i>s</i>/(1 &minus; <i>&theta;</i><sub>c</sub>), <i>&tau;</i> "
            "keeps its "
            "value at the threshold, times exp(<i>&xi;</i>(1 &minus; <i>J</i><sub>P</sub>)); "
            "<i>&sigma;</i> = "
            "<i>&tau;</i>/<i>s</i>",
        ),
        source="Our own derivation from the law of Stomakhin et al. 2013 in uniaxial strain.",
        checks=tuple(checks),
        plots=plots,
        verdict="The whole step, from velocities to hardened stress, follows the law over two decades of "
        "stress.",
        particles=r.particles,
        steps=r.steps,
    )
