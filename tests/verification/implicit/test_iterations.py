"""How many iterations an implicit step takes."""

import pytest

from neve.scene.reading.load import scene_from
from neve.simulation import Simulation
from neve.validate.scenes import box, duct, elastic, plane


@pytest.mark.parametrize("integrator", ["semi_implicit", "implicit"])
def test_the_diagonal_of_the_stiffness_preconditions_snow_that_lies(integrator):
    """Jittered snow of 1e6 Pa on snow of 1e9 Pa: fewer than 150 iterations a step of 5 ms.

    With the diagonal it is 55 and 58, with the masses alone 509 and 526: a node that a particle reaches by a
    small weight w has the mass w m, but a stiffness with w squared.
    """
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
        },
        "sources": [
            box((0, 0, 0), (width, width, height / 2), snow=elastic(E0=1e9, nu=0.2)),
            box((0, 0, height / 2), (width, width, height), snow=elastic(E0=1e6, nu=0.2)),
        ],
        "colliders": [*duct(width, width), plane((0, 0, 0), (0, 0, 1))],
    }
    sim = Simulation(scene_from(tables, where="test"), threads=1)
    sim.advance(0.02)
    assert sim.stats.rejected == 0
    assert sim.diagnostics().solve_iterations < 150
