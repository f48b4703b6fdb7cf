"""Known answer 43: what colliders exchange is what snow has lost, in momentum; and the work they do."""

import numpy as np
from verification.scenes import box, march, scene, simulate

COLLIDERS = [
    {"shape": "plane", "point": (0, 0, -0.12), "normal": (0.1, 0, 1), "mu_c": 0.3},
    {"shape": "box", "center": (-0.16, 0, 0), "size": (0.1, 0.3, 0.3), "velocity": (4, 0, 1), "mode": "slip"},
    {"shape": "sphere", "center": (0.14, 0.02, 0.02), "radius": 0.08, "spin": (0, 30, 9), "mode": "sticky"},
]  # fmt: skip


def squeezed(precision, spline, transfer):
    description = scene(
        [box(velocity=(1, 0.5, -3), spin=(0, 5, 0))], COLLIDERS,
        precision=precision, spline=spline, transfer=transfer, dt=1.5e-4,
    )  # fmt: skip
    return simulate(description)


def test_impulses(precision, spline, transfer, eps):
    """Without gravity the impulses on the colliders add up to minus the change of the snow's momentum.

    Summed in double from values rounded to eps: per step and particle an error of eps m |v| with random sign,
    as in known answer 4, hence steps eps sum m |v|.
    """
    sim = squeezed(precision, spline, transfer)
    before, steps = np.array(sim.diagnostics().momentum), 100
    flux = float((np.asarray(sim.state.m) * np.linalg.norm(sim.state.v, axis=1)).sum())
    march(sim, steps)
    change = np.array(sim.diagnostics().momentum) - before
    impulse = sim.exchanged[:, :3].sum(0)
    np.testing.assert_allclose(impulse, -change, rtol=0, atol=steps * eps * flux)
    assert (np.linalg.norm(sim.exchanged[:, :3], axis=1) > 0.05 * flux).all()  # each collider was hit
    np.testing.assert_array_equal(sim.stats.exchanged, sim.exchanged)


def test_force_of_rest(transfer):
    """Snow at rest on a plane: the impulse of a second is its weight.

    Exactly so once what momentum the snow still gains is counted; to 5 % without.
    """
    description = scene(
        [box(center=(0, 0, 0.1), size=(0.2, 0.2, 0.2))], [{"shape": "plane"}], gravity=(0, 0, -10.0), dt=5e-4,
        transfer=transfer, flip_alpha=0.9, snow={"plasticity": "none"},
    )  # fmt: skip
    sim = march(simulate(description), 800)
    weight = sim.diagnostics().mass * 10.0
    before = np.array(sim.diagnostics().momentum)
    march(sim, 400)
    gained = np.array(sim.diagnostics().momentum) - before
    np.testing.assert_allclose(
        sim.stats.exchanged[0, :3] / 0.2, (0, 0, -weight) - gained / 0.2, atol=1e-6 * weight
    )
    np.testing.assert_allclose(sim.stats.exchanged[0, 2] / 0.2, -weight, rtol=0.05)


def test_work(transfer):
    """A floor at rest does no work; a box that pushes snow along x does: its impulse times its velocity."""
    sim = march(squeezed("float64", "quadratic", transfer), 100)
    floor, pusher, _ = sim.exchanged
    assert floor[6] == 0.0
    np.testing.assert_allclose(pusher[6], -pusher[:3] @ (4, 0, 1), rtol=1e-12)
    assert pusher[6] > 0
