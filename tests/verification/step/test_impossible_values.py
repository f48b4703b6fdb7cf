"""Values that no snow has, written into the state: refused with one sentence before a step is taken."""

import numpy as np
import pytest
from verification.scenes import box, scene, simulate

from neve import _core
from neve.solver import Blowup


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("F_E", np.diag([1.0, 1.0, -1.0]), "determinant"),
        ("F_E", np.diag([1.0, 1.0, 0.0]), "determinant"),
        ("F_E", np.outer([1.0, 0.3, 0.7], [0.2, 0.9, 1.3]), "determinant"),
        ("F_E", np.full((3, 3), np.nan), "determinant"),
        ("J_P", 0.0, "above zero"),
        ("J_P", -1.0, "above zero"),
        ("J_P", np.inf, "above zero"),
        ("x", np.nan, "finite"),
        ("v", np.inf, "finite"),
        ("C", np.nan, "finite"),
        ("m", 0.0, "mass above zero"),
        ("m", -2.0, "mass above zero"),
        ("V0", -1.0, "volume above zero"),
        ("stiffness", -1.0, "above zero"),
        ("stiffness", 0.0, "above zero"),
        ("strength", -0.5, "at least zero"),
        ("material", 7, "from 0 to 0"),
    ],
)
def test_impossible_values_are_refused(precision, field, value, says):
    """Written into sim.state they are one sentence at the next advance, and at the next diagnostics."""
    sim = simulate(scene([box()], precision=precision, dx=0.1))
    sim.advance(1e-4)
    getattr(sim.state, field)[5] = value
    for use in (lambda: sim.advance(1e-4), sim.diagnostics):
        with pytest.raises(Blowup) as stop:
            use()
        told = str(stop.value)
        assert f"particle {sim.state.id[5]} " in told
        assert f"state.{field} = " in told
        assert says in told
        assert "\n" not in told


def test_what_is_legal_is_taken():
    """Particles on top of one another, F_E stretched a thousandfold, strength 0: all of it is possible."""
    sim = simulate(scene([box()], dx=0.1))
    sim.state.x[...] = sim.state.x[0]
    sim.state.F_E[3] = np.diag([1e3, 1.0, 1e-3])
    sim.state.strength[4] = 0.0
    assert _core.f64.inspect(sim.solver.model.native, sim.state)[0] == -1
