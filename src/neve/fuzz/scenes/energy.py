"""The energy of a run, step by step, without the swing of explicit steps, and what nothing accounts for.

An explicit step moves velocities first and positions with the new ones (symplectic Euler). Of a stable linear
vibration of angular frequency w it keeps, to rounding, not the energy of a state but the shadow energy

    H_n = 1/2 <v_n, v_n+1> + V(x_n)

with the inner product of the kinetic energy and V the elastic and potential energy; the sum of kinetic energy
and V swings between H / (1 + a) and H / (1 - a), a = w dt / 2. Transfers, plastic flow and contact make H
less. So a rise of H is energy from nowhere, be the swing small or large. A blow that changes velocities
within one step is no vibration: there H falls too far and comes back while the plain sum does not rise, so
what counts is the smaller of both rises. Neither would see the linear instability of a step with w dt > 2, in
which H is kept while both its terms grow; so the plain sum alone is judged too, by a wide margin.

Source: Hairer, Lubich and Wanner, Geometric numerical integration, 2nd ed. 2006, IX.3 (modified energy of the
symplectic Euler method) [M].
"""

from __future__ import annotations

from typing import NamedTuple

from neve.diagnostics import Balance

MOST_GAIN = 0.05
"""Rise of the shadow energy that is allowed, as a share of all that was put in since the start."""

MOST_SURGE = 0.25
"""Rise that is allowed as a share of what moved and was strained at most since the lowest H before it."""

LEAST_SURGE, LEAST_AFLIP_SURGE = 1e-3, 1e-2
"""A rise below this share of all that was put in is no surge: snow at rest is no measure.

Explicit steps of motions that are not small make energy of the order of dt, both ways; `aflip`, which damps
least, shows it: in a press 0.6 % of what was put in in 540 steps, and 0.2 % in steps a fifth as long.
"""

MOST_SWING = 0.5
"""Kinetic and elastic energy beyond all that was put in, as a share of it."""


class Moment(NamedTuple):
    """What a step says about the energy of the state before it.

    shared: 1/2 <v_n, v_n+1> [J]; before, after: sums of both states; rounding: bound on what rounding may
    have added since the start, that of strains included, and that of solids in which snow starts by
    rounding [J].
    """

    shared: float
    before: Balance
    after: Balance
    rounding: float


class Budget:
    """The energy that was put into the snow of a run, and the largest rises that nothing accounts for.

    Put in are the energy at the start, the work of colliders, what the snow fell, and what snow brought that
    came, less what left with it. gain: largest rise of
    both the shadow energy and the plain sum, each from its lowest before, over all that was put in until then
    [1]; surge: largest rise over the largest sum of kinetic and elastic energy since then [1]; swing: largest
    sum of kinetic and elastic energy over all that was put in, less 1 [1].
    """

    def __init__(self, transfer: str = "apic") -> None:
        self.gain = self.surge = self.swing = 0.0
        self._least_surge = LEAST_AFLIP_SURGE if transfer == "aflip" else LEAST_SURGE
        self._start: Balance | None = None
        self._put_in = 0.0
        self._lowest = self._lowest_sum = self._alive = 0.0

    def record(self, moment: Moment) -> None:
        """Take in one step."""
        before, after = moment.before, moment.after
        shadow = moment.shared + before.elastic + before.potential - 0.5 * (before.work + after.work)
        shadow -= before.came
        plain = before.kinetic_and_elastic + before.potential - before.work - before.came
        if self._start is None:
            self._start, self._lowest, self._lowest_sum = before, shadow, plain
        start = self._start
        for now in (before, after):
            put_in = (
                start.kinetic_and_elastic
                + max(now.work, 0.0)
                + max(start.potential + now.came - start.came - now.potential, 0.0)
            )
            self._put_in = max(self._put_in, put_in)
        self._alive = max(self._alive, before.kinetic_and_elastic)
        if shadow < self._lowest:
            self._lowest, self._alive = shadow, before.kinetic_and_elastic
        self._lowest_sum = min(self._lowest_sum, plain)
        rise = max(min(shadow - self._lowest, plain - self._lowest_sum) - moment.rounding, 0.0)
        self.gain = max(self.gain, rise / max(self._put_in, 1e-300))
        if rise > self._least_surge * self._put_in:
            self.surge = max(self.surge, rise / max(self._alive, 1e-300))
        over = before.kinetic_and_elastic - moment.rounding - self._put_in
        self.swing = max(self.swing, over / max(self._put_in, 1e-300))

    def fault(self) -> str:
        """Return what is wrong with the energy, "" if nothing is."""
        if self.gain > MOST_GAIN:
            return f"energy grew by {100 * self.gain:.3g} % of what was put in"
        if self.surge > MOST_SURGE:
            return f"energy surged by {100 * self.surge:.3g} % of what moved and was strained"
        if self.swing > MOST_SWING:
            return f"energy swung to {100 * self.swing:.3g} % more than was put in"
        return ""
