"""Known answer 30: the sparse grid is the dense one, wherever the snow is and in whatever order it comes."""

import numpy as np
import pytest
from reference import step
from verification.scenes import ball, bodies, box, march, oracle, scene, simulate, wide

import neve

FLOOR = {"shape": "plane", "point": (0.0, 0.0, -0.141), "normal": (0.0, 0.0, 1.0), "mu_c": 0.4}


def splash(spline, transfer, **numerics):
    """Two lumps far apart but for their fall on the same floor, over positive and negative coordinates."""
    return scene(
        [
            box(center=(-0.61, 0.33, 0.0), size=(0.2, 0.25, 0.2), velocity=(1, 0, -4), spin=(0, 5, 2)),
            ball(center=(0.64, -0.31, 0.0), radius=0.14, velocity=(-1, 1, -3), snow={"xi": 5.0, "E0": 9e4}),
        ],
        [FLOOR],
        gravity=(0, 0, -9.81),
        spline=spline,
        transfer=transfer,
        **numerics,
    )


def test_sparse_is_dense(spline, transfer):
    """A whole Simulation, its first step's volumes included, against the oracle's dense box: 15 steps, 1e-11.

    In float64 a step rounds by 60 eps = 1.3e-14 of a quantity's size, the oracle's LAPACK included, and
    errors travel as waves that dt resolves: 15 steps, 2e-13. The rest is for the first contact with the
    floor, where the force on a node of little mass turns a relative error of its weight into the same of
    its velocity.
    """
    sim = simulate(splash(spline, transfer, dt=2e-4))
    p, method = oracle(sim)
    around = bodies(sim)
    march(sim, 15)
    for k in range(15):
        step.step(p, method, sim.scene.numerics.dt, around, first=k == 0)
    end = wide(sim)
    assert (end["J_P"] < 0.999).any()  # the floor was hit
    np.testing.assert_allclose(end["V0"], p.V0, rtol=1e-12)
    for name, size in {"x": 1.0, "v": 4.0, "F_E": 1.0, "J_P": 1.0}.items():
        np.testing.assert_allclose(end[name], getattr(p, name), rtol=0, atol=1e-11 * size, err_msg=name)


def test_blocks_are_few(spline, transfer):
    """The two lumps above use blocks around themselves: fewer than half of those of a dense box."""
    sim = march(simulate(splash(spline, transfer)), 1)
    x = np.asarray(sim.state.x)
    spans = np.ptp(np.floor(x / (4 * 0.05)), axis=0) + 2
    assert sim.solver.grid.blocks <= spans.prod() / 2


def test_a_flake_far_away_costs_its_own_blocks(precision, spline, transfer):
    """One flake 10 km away adds the eight node blocks of its tile and no more."""
    near = scene([ball(radius=0.2)], precision=precision, spline=spline, transfer=transfer)
    sim = simulate(near)
    arrays = sim.arrays()
    alone = march(sim, 1).solver.grid.blocks
    flake = arrays["id"] == 0
    x = arrays["x"].copy()
    x[flake] = [1e4, -1e4, 1e4]
    far = march(neve.Simulation.restore(near, arrays | {"x": x}, threads=1), 1)
    assert far.solver.grid.blocks <= alone + 8
    assert np.isfinite(np.asarray(far.state.x)).all()
    assert far.bytes < 2 * sim.bytes


@pytest.mark.parametrize("blocks", [(-3, 5, -2), (40, -70, 11)])
def test_translation_by_whole_blocks(spline, transfer, blocks):
    """The same scene, moved by whole blocks, does the same: the grid has no origin.

    Positions up to 15 m carry eps 15/2, which in cells of 0.0625 m is 2.7e-14 a step in the weights; over
    60 steps that is 2e-12 relative, and velocities of 4 m/s and F_E follow it: 1e-10 with a factor for
    contact.
    """
    dx = 0.0625
    shift = 4 * dx * np.array(blocks, float)
    here = simulate(splash(spline, transfer, dx=dx))
    arrays = here.arrays()
    moved = splash(spline, transfer, dx=dx).model_dump()
    moved["colliders"][0]["point"] = tuple(np.array(FLOOR["point"]) + shift)
    there = neve.Simulation.restore(
        neve.Scene.model_validate(moved), arrays | {"x": arrays["x"] + shift}, threads=1
    )
    a, b = wide(march(here, 60)), wide(march(there, 60))
    np.testing.assert_allclose(b["x"] - shift, a["x"], rtol=0, atol=1e-11)
    for name in ("v", "F_E", "J_P"):
        np.testing.assert_allclose(b[name], a[name], rtol=0, atol=1e-10, err_msg=name)


def test_order_of_particles(precision, eps, spline, transfer):
    """Shuffled particles do the same but for the order of the sums: 1e-5 in float32, as much less in float64.

    A node adds its shares in another order, which moves it by sqrt(k) eps for k ~ 100 shares; 40 steps of
    such moves, random and resolved as waves, stay under 100 eps = 1.2e-5.
    """
    description = splash(spline, transfer, precision=precision)
    sim = simulate(description)
    arrays = sim.arrays()
    mix = np.random.default_rng(0).permutation(len(arrays["m"]))
    of_particles = {name for name, value in arrays.items() if len(np.atleast_1d(value)) == len(mix)}
    mixed = {name: value[mix] if name in of_particles else value for name, value in arrays.items()}
    other = march(neve.Simulation.restore(description, mixed, threads=1), 40)
    a, b = wide(march(sim, 40)), wide(other)
    for name, size in {"x": 1.0, "v": 4.0, "F_E": 1.0, "J_P": 1.0}.items():
        np.testing.assert_allclose(b[name], a[name], rtol=0, atol=100 * eps * size, err_msg=name)
