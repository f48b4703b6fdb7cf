"""The diagonal of the stiffness, which preconditions snow that lies: its entries, and what it is good for."""

import numpy as np
import pytest
from reference.laws import unyielding
from verification.material import DEFAULT, near_identity
from verification.scenes import columns
from verification.stages import Lab

from neve import _core
from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.validate.scenes import box, duct, elastic, plane

DT, DX = 2e-3, 0.05


def lump(spline, transfer, precision="float64", n=120, seed=4):
    """Sort snow of elastic law that is pressed and sheared by a tenth, in two cells and a half each way."""
    rng = np.random.default_rng(seed)
    volume = rng.uniform(0.5, 1.5, n) * DX**3 / 8
    lab = Lab(
        _core.f64 if precision == "float64" else _core.f32,
        precision,
        spline,
        transfer,
        (unyielding(DEFAULT),),
        dx=DX,
        x=rng.uniform(-1.25, 1.25, (n, 3)) * DX,
        F_E=near_identity(n, 0.1),
        J_P=np.ones(n),
        V0=volume,
        m=400 * volume,
        stiffness=rng.uniform(0.5, 2, n),
        strength=np.ones(n),
        material=np.zeros(n),
        id=np.arange(n),
    )
    lab.p2g(0.0)
    return lab


def products(lab, project):
    """H applied to a unit velocity of each axis of each node, (k, k) [kg], and its diagonal (k,)."""
    blocks, size = lab.grid.blocks, 64 * 3
    rows = []
    for b in range(blocks):
        u = np.zeros((size, blocks, size), lab.dtype)
        u[np.arange(size), b, np.arange(size)] = 1
        out, diagonal = lab.core.stiffness(
            lab.model, lab.state, lab.grid, DT, u.reshape(size, blocks, 64, 3), project
        )
        rows.append(np.asarray(out).reshape(size, -1))
    return np.concatenate(rows), np.asarray(diagonal).ravel()


@pytest.mark.parametrize("project", [False, True])
@pytest.mark.parametrize("transfer", ["apic", "flip"])
@pytest.mark.parametrize("spline", ["quadratic", "cubic"])
def test_its_entries_are_those_of_the_stiffness(spline, transfer, project):
    """e . H e of every unit velocity e, to 1e-10 of the largest entry; H is symmetric to the same.

    Sums of 120 particles in float64 leave 1e-14. Both kinds of weights: of affine transfers, of gradients.
    """
    H, diagonal = products(lump(spline, transfer), project)
    largest = np.abs(diagonal).max()
    assert largest > 0
    np.testing.assert_allclose(diagonal, H.diagonal(), atol=1e-10 * largest, rtol=0)
    np.testing.assert_allclose(H, H.T, atol=1e-10 * largest, rtol=0)
    assert (np.abs(diagonal) > 1e-6 * largest).sum() > 3 * 27


def test_its_entries_in_float32():
    """The same to 1e-5 of the largest: some ten roundings of a sum over tens of particles."""
    H, diagonal = products(lump("quadratic", "apic", "float32"), True)
    np.testing.assert_allclose(diagonal, H.diagonal(), atol=1e-5 * np.abs(diagonal).max(), rtol=0)


def test_velocities_must_be_of_the_grid():
    """One block too many is refused."""
    lab = lump("quadratic", "apic")
    with pytest.raises(ValueError, match="with the blocks of the grid"):
        lab.core.stiffness(
            lab.model, lab.state, lab.grid, DT, np.zeros((1, lab.grid.blocks + 1, 64, 3)), True
        )


def layers(integrator, diagonal):
    """Lay jittered snow of 1e6 Pa on snow of 1e8 Pa and let it settle, four steps of 5 ms."""
    height, cells = 0.4, 8
    h, width = height / cells, height / 2
    tables = {
        "world": {"gravity": [0, 0, -9.81]},
        "numerics": {
            "dx": h,
            "dt": 5e-3,
            "precision": "float64",
            "sampling": "jittered",
            "integrator": integrator,
            "implicit_tolerance": 1e-7,
            "implicit_iterations": 20000,
        },
        "sources": [
            box((0, 0, 0), (width, width, height / 2), snow=elastic(E0=1e8, nu=0.2)),
            box((0, 0, height / 2), (width, width, height), snow=elastic(E0=1e6, nu=0.2)),
        ],
        "colliders": [*duct(width, width), plane((0, 0, 0), (0, 0, 1))],
    }
    sim = Simulation(scene_from(tables, where="test"), threads=1)
    native = sim.solver.implicit._native
    native.diagonal = diagonal
    sim.advance(0.02)
    assert sim.stats.rejected == 0
    return sim


@pytest.mark.parametrize("integrator", ["semi_implicit", "implicit"])
def test_it_leads_to_the_same_answer_in_fewer_iterations(integrator):
    """Velocities to 1e-5 of the fall that the ground has stopped, in less than a third of the iterations."""
    plain, helped = (layers(integrator, on) for on in (False, True))
    v = [columns(sim)["v"] for sim in (plain, helped)]
    np.testing.assert_allclose(v[1], v[0], atol=1e-5 * 9.81 * 0.02, rtol=0)
    counts = [sim.diagnostics().solve_iterations for sim in (plain, helped)]
    assert counts[1] < counts[0] / 3
