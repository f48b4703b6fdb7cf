"""Results: what a case measured, what is exact, how far apart the two may be, and why."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rule = Literal["within", "at most", "at least"]
Kind = Literal["measured", "joined", "dots", "exact", "other"]
Scale = Literal["linear", "log"]


@dataclass(frozen=True)
class Check:
    """Compare one measured number with one that is known.

    Attributes:
        quantity: what was measured, in a few words
        measured: the number found
        exact: the number known
        tolerance: how far `measured` may be from `exact`, in the same unit (0 for a bound)
        reason: where the tolerance comes from
        unit: of all three; "" for a pure number
        rule: "within" the tolerance, or a bound: "at most" or "at least" `exact`
    """

    quantity: str
    measured: float
    exact: float
    tolerance: float
    reason: str
    unit: str = ""
    rule: Rule = "within"

    @property
    def ok(self) -> bool:
        """Whether the number is where it should be; one that is not finite never is."""
        if not math.isfinite(self.measured):
            return False
        if self.rule == "at most":
            return bool(self.measured <= self.exact)
        if self.rule == "at least":
            return bool(self.measured >= self.exact)
        return bool(abs(self.measured - self.exact) <= self.tolerance)


def near(quantity: str, measured: float, exact: float, relative: float, reason: str, unit: str = "") -> Check:
    """Return the check that `measured` lies within the share `relative` of `exact`."""
    return Check(quantity, float(measured), float(exact), abs(float(exact)) * relative, reason, unit)


def at_most(quantity: str, measured: float, bound: float, reason: str, unit: str = "") -> Check:
    """Return the check that `measured` is no larger than `bound`."""
    return Check(quantity, float(measured), float(bound), 0.0, reason, unit, "at most")


def at_least(quantity: str, measured: float, bound: float, reason: str, unit: str = "") -> Check:
    """Return the check that `measured` is no smaller than `bound`."""
    return Check(quantity, float(measured), float(bound), 0.0, reason, unit, "at least")


@dataclass(frozen=True)
class Curve:
    """Hold points (x, y) of a plot; an exact curve may carry its tolerance as a band from `low` to `high`."""

    label: str
    x: Array
    y: Array
    kind: Kind = "measured"
    low: Array | None = None
    high: Array | None = None


@dataclass(frozen=True)
class Plot:
    """Hold the curves of one picture, its axes with units, and a line that says what to see."""

    title: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    x_scale: Scale = "linear"
    y_scale: Scale = "linear"
    equal: bool = False  # one metre along x is as long as one along y


@dataclass(frozen=True)
class Result:
    """Hold all that one case has to say; text may hold the HTML tags <sub>, <sup>, <i> and <b>.

    Attributes:
        what: the experiment in a few sentences
        equations: the exact answer, a line each
        source: where the exact answer comes from, with a tag where it is not our own derivation
        verdict: what the numbers mean, in words
        particles, steps: the size of the work, over all runs of the case
    """

    what: str
    equations: tuple[str, ...]
    source: str
    checks: tuple[Check, ...]
    plots: tuple[Plot, ...]
    verdict: str
    particles: int = 0
    steps: int = 0
    remarks: tuple[str, ...] = field(default=())

    @property
    def ok(self) -> bool:
        """Whether every check holds."""
        return all(check.ok for check in self.checks)


def band(label: str, x: Array, y: Array, tolerance: Array | float) -> Curve:
    """Return an exact curve with the band `tolerance` on both sides of it."""
    return Curve(label, x, y, "exact", y - tolerance, y + tolerance)
