"""A Simulation with scripted colliders is the oracle.

Who stands where, when, and in what order, over whole steps.
"""

import numpy as np
from reference import step
from verification.scenes import ball, bodies, box, march, oracle, scene, simulate, wide

TURN = {"t": 0.002, "position": (0.12, 0.02, -0.05), "rotation": (0, 20, 40)}
COLLIDERS = [
    {"shape": "plane", "point": (0, 0, -0.131), "normal": (0.1, 0, 1), "mu_c": 0.3, "velocity": (0, 0, 2)},
    {
        "shape": "box", "center": (-0.13, 0, 0.02), "size": (0.1, 0.17, 0.09), "rotation": (10, 20, 30),
        "mode": "slip", "mu_c": 0.2, "velocity": (5, 0, 1), "spin": (0, 30, 20),
    },
    {
        "shape": "box", "size": (0.07, 0.13, 0.11), "mode": "sticky",
        "keyframes": [{"t": 0.0, "position": (0.15, 0.02, -0.06)}, TURN],
    },
    {"shape": "cylinder", "center": (0.02, 0.12, 0), "radius": 0.04, "height": 0.2, "spin": (0, 0, 9)},
]  # fmt: skip


def stirred(spline, transfer):
    return scene(
        [
            ball(radius=0.13, velocity=(0, 0, -3), spin=(0, 20, 5)),
            box(center=(0.17, 0.1, 0.13), size=(0.1, 0.1, 0.1), velocity=(-5, 0, -8), snow={"xi": 3.0}),
        ],
        COLLIDERS, gravity=(0, 0, -9.81), spline=spline, transfer=transfer, dt=1e-4,
    )  # fmt: skip


def test_moving_colliders(spline, transfer):
    """Fourteen steps in one advance(): bodies where their scripts have them as each step begins; 1e-11.

    The poses are read off a second Simulation that goes step by step. A step rounds by 60 eps, the oracle's
    LAPACK included; poses at times summed up in another order differ by eps t |v|.
    """
    sim, clock = simulate(stirred(spline, transfer)), simulate(stirred(spline, transfer))
    p, method = oracle(sim)
    first = bodies(clock)
    march(sim, 14)
    for k in range(14):
        step.step(p, method, 1e-4, bodies(clock), first=k == 0)
        march(clock, 1)
    assert all(np.abs(a.position - b.position).max() + np.abs(a.rotation - b.rotation).max() > 1e-3
               for a, b in zip(first, bodies(clock), strict=True))  # fmt: skip
    end = wide(sim)
    for name, size in {"x": 1.0, "v": 10.0, "F_E": 1.0, "J_P": 1.0}.items():
        np.testing.assert_allclose(end[name], getattr(p, name), rtol=0, atol=1e-11 * size, err_msg=name)


def test_laws_of_sources():
    """Five sources that touch, each with a law of its own, thrown on a floor: twelve steps, 1e-11 as above.

    Layers and noise aside, what a scene says about a snow reaches its particles: law, plasticity, constants.
    """
    snows = [
        {"law": "stomakhin2013", "xi": 5.0},
        {"law": "neo_hookean", "plasticity": "none", "E0": 2e5},
        {"law": "hencky", "theta_c": 0.01},
        {"law": "drucker_prager", "cohesion": 300.0, "friction_angle": 30.0},
        {"law": "cam_clay", "E0": 4e5, "p0": 800.0, "beta": 0.2},
    ]
    blocks = [
        box(center=(0.11 * k, 0.0, 0.0), size=(0.11, 0.11, 0.11), velocity=(-3.0 * k, 0, -6), snow=snow)
        for k, snow in enumerate(snows)
    ]
    floor = [{"shape": "plane", "point": (0, 0, -0.03), "normal": (0, 0, 1), "mu_c": 0.3}]
    description = scene(blocks, floor, gravity=(0, 0, -9.81), dt=2e-4)
    sim = simulate(description)
    p, method = oracle(sim)
    assert set(p.law.law) == {snow["law"] for snow in snows}
    march(sim, 12)
    J_P = p.J_P.copy()
    for k in range(12):
        step.step(p, method, 2e-4, bodies(sim), first=k == 0)
    assert (p.J_P != J_P).mean() > 0.3
    end = wide(sim)
    for name, size in {"x": 1.0, "v": 10.0, "F_E": 1.0, "J_P": 1.0}.items():
        np.testing.assert_allclose(end[name], getattr(p, name), rtol=0, atol=1e-11 * size, err_msg=name)
