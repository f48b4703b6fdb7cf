"""The longest step of particles against all eigenvalues of their stiffness and dampers."""

import numpy as np
import pytest
from verification.particles.common import particles

SOFT = {"law": "drucker_prager", "cohesion": 500.0, "E0": 1e5, "friction_angle": 30.0}


def matrices_of(sim):
    """Return the stiffness and the dampers of all bonds and contacts (n, 3, n, 3) [N/m, N s/m], and the kinds
    of pairs that there are: whether bonded, whether wet.
    """
    state, n = sim.state, sim.count
    begin, row, memory = (np.asarray(a) for a in state.contacts())
    x, m, k, r = (np.asarray(getattr(state, name)) for name in ("x", "m", "k", "radius"))
    liquid = np.asarray(state.liquid)
    damping = 2 * 0.1 * np.sqrt(np.min(m / (2 * k)))
    K, C = np.zeros((n, 3, n, 3)), np.zeros((n, 3, n, 3))
    kinds = set()
    for i in range(n):
        for e in range(begin[i], begin[i + 1]):
            j, hold = row[e], memory[e, 0]
            stiff, wet = 0.5 * (k[i] + k[j]), max(liquid[i], liquid[j])
            d = x[i] - x[j]
            n_n = np.outer(d, d) / (d @ d)
            along = np.eye(3) - n_n if hold < 0 and wet < 1 else np.zeros((3, 3))
            pressed = hold < 0 and np.linalg.norm(d) < r[i] + r[j]
            spring, damper = stiff * (n_n + 0.5 * along), stiff * damping * (n_n + along)
            if hold < 0 and wet > 0:
                time = max(damping, wet * 1.5 * 2 * np.sqrt(m[i] * m[j] / (m[i] + m[j]) / stiff))
                damper = damper + stiff * (time - damping) * n_n
            if hold < 0 and not pressed:
                damper = 0 * damper
            for A, a in ((K, spring), (C, damper)):
                A[i, :, i] += a
                A[i, :, j] -= a
            kinds.add((hold > 0, wet > 0))
    return K, C, kinds


@pytest.mark.parametrize("wet", [False, True])
def test_no_step_is_longer_than_is_stable(wet):
    """The step that the solver would take for lumps in contact makes no vibration grow.

    K and C of all bonds and contacts that stick, with their dampers, are put together here: of steps
    v += -dt M^-1 (K u + C v), u += dt v no eigenvalue is above 1, while with 1.6 times the bound some are:
    which is longer than half the limit by the sum of all stiffness, 1 / sqrt(sum k / m).

    wet: a third of the particles is water, a third is slush, whose dampers are far beyond those of snow.
    """
    lumps = [
        {"shape": "sphere", "center": (-0.09, 0, 0), "radius": 0.08, "velocity": (3, 0, 0.5)},
        {"shape": "sphere", "center": (0.09, 0.01, 0.03), "radius": 0.08, "velocity": (-3, 0, 0)},
    ]
    sim = particles(lumps, snow=SOFT, dt=2e-4)
    sim.advance(0.012)
    if wet:
        sim.state.liquid[...] = (np.asarray(sim.state.id) % 3) / 2
    sim.solver.begin(sim.steps, sim.time)
    n, m = sim.count, np.asarray(sim.state.m)
    K, C, kinds = matrices_of(sim)
    assert kinds == {(bonded, damp) for bonded in (True, False) for damp in {wet, False}}
    K, C = (A.reshape(3 * n, 3 * n) / np.repeat(m, 3)[:, None] for A in (K, C))

    def growth(dt):
        """Return the largest eigenvalue of a step, by its size."""
        one = np.eye(3 * n)
        turned = np.hstack((-dt * K, one - dt * C))
        return np.abs(np.linalg.eigvals(np.vstack((np.hstack((one, 0 * one)) + dt * turned, turned)))).max()

    longest = 1 / sim.solver._report.rate
    assert growth(longest) <= 1 + 1e-6  # the six motions of rigid bodies are double eigenvalues of 1
    assert wet or growth(1.6 * longest) > 1.1
    assert wet or longest > 1.2 / np.sqrt(sim.solver._report.stiffest)
