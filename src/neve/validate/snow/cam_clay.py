"""The yield surface of cam_clay, and its compression through the whole step (known answer 25)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from neve import _core
from neve.scene.schema.material import Snow
from neve.scene.values.elastic import bulk_modulus, lame
from neve.validate.result import Check, Curve, Plot, Result, at_least, at_most, band, near
from neve.validate.snow.oedometer import Compression, compress

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

KINDS = ("cold_dense", "sliding_slab")
LEAST = 0.8
"""The compression ends at this height over the first [1]."""


def shear_and_bulk(snow: Snow) -> tuple[float, float]:
    """Return mu and K [Pa]."""
    return lame(snow.E0, snow.nu)[0], bulk_modulus(snow.E0, snow.nu)


def overstress(snow: Snow, p: Array, q: Array, p0: Array | float) -> Array:
    """Return y = (1 + 2 beta) q^2 + M^2 (p + beta p0) (p - p0) over p0^2 [1]: above 0 is outside."""
    y = (1 + 2 * snow.beta) * q**2 + snow.M**2 * (p + snow.beta * p0) * (p - p0)
    return np.asarray(y / np.asarray(p0) ** 2)


def return_map(snow: Snow, count: int = 4000) -> tuple[Array, Array, Array, Mask]:
    """Return p, q and p0 [Pa] after the return map of random trial states, and whether each had to flow.

    The trials are up to three half-axes away from the ellipse, rotated at random.
    """
    rng = np.random.default_rng(25)
    mu, K = shear_and_bulk(snow)
    p = snow.p0 * (rng.random(count) * (3 + 3 * snow.beta) - 1 - 2 * snow.beta)
    dev = rng.standard_normal((count, 3))
    dev -= dev.mean(1, keepdims=True)
    q = 1.5 * snow.M * snow.p0 * rng.random(count)
    dev *= (q / (np.sqrt(6) * mu * np.linalg.norm(dev, axis=1)))[:, None]
    stretch = np.exp(dev - (p / (3 * K))[:, None])
    turn = np.linalg.qr(rng.standard_normal((count, 3, 3)))[0]
    F = np.einsum("nij,nj,nkj->nik", turn, stretch, turn)
    constants = {name: value for name, value in snow.model_dump().items() if isinstance(value, float)}
    mapped = _core.f64.law("cam_clay", "snow", constants, F, np.ones(count), np.ones(count))
    J_P, tau = np.asarray(mapped[1]), np.asarray(mapped[2])
    p_now = -np.trace(tau, axis1=1, axis2=2) / 3
    s = tau + p_now[:, None, None] * np.eye(3)
    q_now = np.sqrt(1.5 * (s**2).sum((1, 2)))
    w = np.arcsinh(snow.p0 / K) - snow.xi * np.log(np.clip(J_P, snow.J_P_min, snow.J_P_max))
    p0 = np.asarray(K * np.maximum(np.sinh(np.maximum(w, 0)), 1e-6))
    return np.asarray(p_now), np.asarray(q_now), p0, np.asarray(overstress(snow, p, q, snow.p0) > 0)


def confined(snow: Snow, s: Array, steps: int = 40000) -> tuple[Array, Array, Array]:
    """Return axial and sideways Cauchy stress [Pa] and path (p, q, p0) [Pa] of confined compression to `s`.

    The rate equations of associated plasticity, in steps of equal logarithmic strain: on the ellipse the flow
    L (dy/dp, dy/dq) keeps y = 0 while p0 = K sinh(-xi alpha) grows with the plastic compaction.
    """
    mu, K = shear_and_bulk(snow)
    M2, beta, xi = snow.M**2, snow.beta, snow.xi
    d = -np.log(float(s.min())) / steps
    p = q = 0.0
    w = float(np.arcsinh(snow.p0 / K))  # -xi alpha
    path = np.zeros((steps + 1, 3))
    for i in range(steps):
        p0 = K * np.sinh(w)
        flow = 0.0
        y_p, y_q = M2 * (2 * p + (beta - 1) * p0), 2 * (1 + 2 * beta) * q
        if (1 + 2 * beta) * q * q + M2 * (p + beta * p0) * (p - p0) >= 0:
            y_p0 = M2 * ((beta - 1) * p - 2 * beta * p0)
            hardening = -y_p0 * K * xi * np.cosh(w) * y_p
            flow = max((y_p * K + 2 * mu * y_q) * d / (K * y_p**2 + 3 * mu * y_q**2 + hardening), 0.0)
        p, q = p + K * (d - flow * y_p), q + 2 * mu * d - 3 * mu * flow * y_q
        w += xi * flow * y_p
        path[i + 1] = p, q, K * np.sinh(w)
    strain = d * np.arange(steps + 1)
    p_s, q_s = (np.interp(-np.log(s), strain, path[:, k]) for k in (0, 1))
    return -(p_s + 2 * q_s / 3) / s, -(p_s - q_s / 3) / s, path


def case() -> Result:
    """Measure the yield surface and the compression of two snows."""
    snows = {kind: Snow.model_validate({"kind": kind}) for kind in KINDS}
    runs = {kind: compress(snow={"kind": kind}, last=LEAST - 0.03) for kind in KINDS}
    return Result(
        what="Random trial stresses go through the return map of cohesive snow, and must end on the ellipse "
        "of Cam-Clay, as large as it is when they get there. Then the same snow is compressed in a rigid "
        "ring through the whole step, and its "
        "stress is held against the rate equations of plasticity, solved on their own in 40,000 steps.",
        equations=(
            "<i>y</i> = (1 + 2<i>&beta;</i>)<i>q</i><sup>2</sup> + <i>M</i><sup>2</sup>(<i>p</i> + "
            "<i>&beta;p</i><sub>0</sub>)(<i>p</i> &minus; <i>p</i><sub>0</sub>) &le; 0",
            "<i>p</i><sub>0</sub> = <i>K</i> sinh(<i>&xi;</i> max(&minus;<i>&alpha;</i>, 0)), "
            "associated flow",
        ),
        source="Gaume et al. 2018; constants of Li et al. 2021, table 1, as quoted in a public code [C]; the "
        "solution of the rate equations is ours.",
        checks=tuple(check for kind in KINDS for check in _checks(kind, snows[kind], runs[kind])),
        plots=(*(_ellipse(kind, snows[kind]) for kind in KINDS), _compression(snows, runs)),
        verdict="Stresses come back to the ellipse to rounding, and the step as a whole follows the law.",
        particles=sum(r.particles for r in runs.values()),
        steps=sum(r.steps for r in runs.values()),
    )


def _checks(kind: str, snow: Snow, r: Compression) -> list[Check]:
    p, q, p0, flowed = return_map(snow)
    y = overstress(snow, p, q, p0)
    axial, sideways, _ = confined(snow, r.s)
    checks = [
        at_most(
            f"{kind}: farthest off the ellipse, |y| / p0<sup>2</sup>",
            np.abs(y[flowed]).max(),
            1e-9,
            "rounding of float64 through logarithm and Newton's steps",
        ),
        at_least(
            f"{kind}: share of trials that had to flow", flowed.mean(), 0.3, "else the check says little"
        ),
    ]
    for mark in (0.95, 0.9, LEAST):
        k = int(np.argmin(np.abs(r.s - mark)))
        reason = "3 % for snow in motion: waves from the piston, and particles that meet walls"
        checks.append(
            near(f"{kind}: axial stress at s = {r.s[k]:.3f}", r.axial[k], axial[k], 0.03, reason, "Pa")
        )
        checks.append(
            near(
                f"{kind}: sideways stress at s = {r.s[k]:.3f}", r.sideways[k], sideways[k], 0.03, reason, "Pa"
            )
        )
    return checks


def _ellipse(kind: str, snow: Snow) -> Plot:
    p, q, p0, flowed = return_map(snow)
    x = np.linspace(-snow.beta, 1, 400)
    y = snow.M * np.sqrt(np.maximum((x + snow.beta) * (1 - x), 0) / (1 + 2 * snow.beta))
    return Plot(
        f"Yield surface of {kind}",
        "p / p0 [1]",
        "q / p0 [1]",
        (
            Curve("ellipse", x, y, "exact"),
            Curve("inside: elastic", (p / p0)[~flowed], (q / p0)[~flowed], "dots"),
            Curve("after the return map", (p / p0)[flowed][::8], (q / p0)[flowed][::8], "dots"),
        ),
    )


def _compression(snows: dict[str, Snow], runs: dict[str, Compression]) -> Plot:
    curves: list[Curve] = []
    for kind, snow in snows.items():
        r = runs[kind]
        axial = confined(snow, r.s)[0]
        curves += [
            band("rate equations, 3 %" if not curves else "", r.s, -axial, 0.03 * -axial),
            Curve(kind, r.s[::2], -r.axial[::2]),
        ]
    return Plot(
        "Confined compression",
        "height over first height, s [1]",
        "axial pressure [Pa]",
        tuple(curves),
        y_scale="log",
    )
