"""The fields of the state, the contract of the core and the arrays themselves agree."""

import ast
from pathlib import Path

import numpy as np
import pytest
from verification.scenes import ball, scene, simulate

import neve
from neve import _core
from neve.mpm.state import FIELDS

CONTRACT = ast.parse((Path(neve.__file__).parent / "_core.pyi").read_text(encoding="utf-8"))


def members(name):
    """Docstring of each property of a class of the contract."""
    [found] = [node for node in CONTRACT.body if isinstance(node, ast.ClassDef) and node.name == name]
    return {node.name: ast.get_docstring(node) for node in found.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("field", FIELDS, ids=lambda field: field.name)
def test_a_field_is_as_the_contract_says(precision, field):
    """Shape and type of the array; the unit and the shape stand in the contract."""
    sim = simulate(scene([ball()], precision=precision))
    array = np.asarray(getattr(sim.state, field.name))
    row = tuple(sim.solver.model.native.more_modes if side == "k" else side for side in field.shape)
    assert array.shape == (sim.count, *row)
    assert array.dtype == (precision if field.dtype == "real" else field.dtype)
    text = members("State")[field.name]
    assert f"[{field.unit}]" in text or not field.unit
    shape = ", ".join("more_modes" if side == "k" else str(side) for side in field.shape)
    assert (f"(n, {shape})" if shape else "(n,)") in text


def test_stress_is_in_the_order_of_the_contract(precision):
    """Zero before the first step; then tau = 2 mu e + lam tr(e) for a small strain e, xx yy zz xy xz yz."""
    sim = simulate(scene([ball()], precision=precision, snow={"law": "neo_hookean", "plasticity": "none"}))
    assert members("State")["tau"].startswith(
        "Kirchhoff stress P F_E^T [Pa], (n, 6), in the order xx yy zz xy xz yz."
    )
    assert not np.asarray(sim.state.tau).any()
    e = 1e-3 * np.array([[1, 4, 5], [4, 2, 6], [5, 6, 3]])
    sim.state.F_E[:] = np.eye(3) + e
    sim.solver.model.core.refresh(sim.solver.model.native, sim.state)
    snow = sim.scene.snow
    mu = snow.E0 / (2 * (1 + snow.nu))
    tau = np.asarray(sim.state.tau, float)[0]
    off = np.array([4e-3, 5e-3, 6e-3])
    np.testing.assert_allclose(tau[3:], 2 * mu * off, rtol=0.02)
    np.testing.assert_allclose(tau[1] - tau[0], 2 * mu * 1e-3, rtol=0.05)
    np.testing.assert_allclose(tau[2] - tau[1], 2 * mu * 1e-3, rtol=0.05)


def test_members_of_the_contract_are_those_of_the_core():
    """Each array, number and stage of the contract is there in both precisions, and each has a sentence."""
    for core in (_core.f32, _core.f64):
        for name in ("State", "Grid", "Model"):
            for member, text in members(name).items():
                assert hasattr(getattr(core, name), member)
                assert text, (name, member)
