"""Corners of float32 and of the tile, found by review: each once broke a run or a promise."""

import numpy as np
import pytest
from verification.material import DEFAULT, parameters
from verification.scenes import ball, scene, simulate

import neve
from neve import _core
from neve.solver import Blowup

DX = 0.05
THIN = {"theta_c": 0.005, "theta_s": 0.005}  # as xi = 100 asks for


def lone_particle(core, spline, transfer, position):
    """Make a model, a state of one particle at `position` [cells] and a sorted grid."""
    model = core.Model(DX, spline, transfer, 0.95, np.zeros(3))
    model.add_snow("stomakhin2013", "snow", parameters(DEFAULT))
    state, grid = core.State(1, model.more_modes), core.Grid()
    state.x[:] = np.asarray(position) * DX
    state.v[:] = (1.0, -2.0, 3.0)
    state.m[:] = 400 * DX**3 / 8
    state.V0[:] = DX**3 / 8
    core.refresh(model, state)
    core.sort(model, state, grid)
    return model, state, grid


@pytest.mark.parametrize(
    ("spline", "f"),
    [("cubic", 1.5e-4), ("cubic", 1e-4), ("cubic", 6e-5), ("quadratic", 1e-6), ("quadratic", 5e-7)],
)
def test_node_of_denormal_mass(spline, transfer, f):
    """At a fraction f of a cell on all axes a corner node's weight is f^9/216 or f^6/8: m is denormal.

    1/m overflows then; the node is to count as empty, and the particle keeps its velocity to rounding.
    """
    shift = {"quadratic": 0.5, "cubic": 0.0}[spline]
    core = _core.f32
    model, state, grid = lone_particle(core, spline, transfer, [shift + f] * 3)
    core.p2g(model, state, grid, 1e-4)
    core.grid_update(model, grid, 1e-4)
    report = core.g2p(model, state, grid, 1e-4)
    assert report.finite
    np.testing.assert_allclose(state.v[0], [1, -2, 3], rtol=1e-5)


def test_end_of_the_tile(core, spline, transfer):
    """A particle that drifts to the very end of its tile has exact weights or asks for a sort.

    The first moment of the scattered mass is the particle's position, to 60 eps of the coordinate in cells.
    """
    end = {"quadratic": 6.5, "cubic": 6.0}[spline]  # u = x/dx - shift reaches 6 or 5
    for before_end in (2e-3, 9e-4, 5e-4, 1e-5):
        model, state, grid = lone_particle(core, spline, transfer, [2.6, 2.6, 2.6])
        start = end - before_end - 0.4
        state.x[:] = start * DX  # still inside: no sort needed
        state.v[:] = 0.4 * DX / 1e-3
        core.p2g(model, state, grid, 1e-3)
        core.grid_update(model, grid, 1e-3)
        core.g2p(model, state, grid, 1e-3)
        if not grid.current:
            core.sort(model, state, grid)
        core.p2g(model, state, grid, 0.0)
        ijk, mass, _ = grid.nodes()
        centre = (ijk * mass[:, None].astype(float)).sum(0) / mass.sum(dtype=float)
        eps = np.finfo(state.x.dtype).eps
        np.testing.assert_allclose(centre, state.x[0].astype(float) / DX, rtol=0, atol=60 * eps * end)


def test_stress_without_bound_names_its_particle():
    """xi = 100 and J_P = 0.05 make exp(95): the stress overflows float32, and that particle is named."""
    sim = simulate(scene([ball()], precision="float32", snow={"xi": 100.0, "J_P_min": 0.01} | THIN))
    sim.state.J_P[3] = 0.05
    sim.state.F_E[3] = 0.99 * np.eye(3)
    with pytest.raises(Blowup, match=rf"^particle {int(sim.state.id[3])} .*(stress|lower|raise)"):
        sim.advance(1e-3)


def test_a_step_that_would_never_end():
    """A legal but absurd hardness asks for dt = 1e-19 s: one sentence, not a run without end."""
    sim = simulate(
        scene(
            [ball()],
            precision="float64",
            dt="auto",
            snow={"xi": 100.0, "J_P_min": 0.25, "J_P_max": 2.0} | THIN,
        )
    )
    sim.state.J_P[3] = 0.2
    with pytest.raises(Blowup, match=r"J_P_min"):
        sim.advance(1.0)


def test_threads_are_checked():
    for threads in (0, -1, 10**6):
        with pytest.raises(ValueError, match="threads"):
            neve.Simulation(scene([ball()]), threads=threads)
