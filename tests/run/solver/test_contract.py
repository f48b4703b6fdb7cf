"""The fields of the state, the contract of the core and the arrays themselves agree."""

import ast
from pathlib import Path

import numpy as np
import pytest
from verification.scenes import ball, scene, simulate

import neve
from neve import _core, _cpu, _render, _surface
from neve.mpm.state import FIELDS
from neve.solver import Field

STUBS = {
    name: ast.parse((Path(neve.__file__).parent / f"{name}.pyi").read_text(encoding="utf-8"))
    for name in ("_core", "_render", "_surface", "_cpu")
}
CONTRACT = STUBS["_core"]
TAU = Field("tau", (6,), "Pa", "real", "Kirchhoff stress, which FIELDS leaves out")
ALIASES = {"Reals", "Array64", "Triple"}
PARTS = {
    "Heat": (),
    "Ranks": (),
    "Geometry": ("TriangleMesh", "SdfGrid", "HeightField"),
    "Snowfall": ("Columns",),
    "Precision": ("Model", "State", "Grid", "ImplicitSolver", "Particles", "Sph"),
}
"""Types of the parts of the core, and the classes that lie in them."""


def members(name):
    """Docstring of each property of a class of the contract."""
    [found] = [node for node in CONTRACT.body if isinstance(node, ast.ClassDef) and node.name == name]
    return {node.name: ast.get_docstring(node) for node in found.body if isinstance(node, ast.FunctionDef)}


def names_of(body):
    """Public names that a module or class of a stub defines: classes, functions, variables."""
    found = set()
    for node in body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.AnnAssign):
            found.add(node.target.id)
        elif isinstance(node, ast.Assign):
            found.update(target.id for target in node.targets)
    return {name for name in found if not name.startswith("_")}


def class_names(stub, name):
    """Public members of a class of a stub, with those of its bases in the same stub."""
    [found] = [node for node in stub.body if isinstance(node, ast.ClassDef) and node.name == name]
    here = {node.name for node in stub.body if isinstance(node, ast.ClassDef)}
    bases = [base.id for base in found.bases if isinstance(base, ast.Name) and base.id in here]
    return names_of(found.body).union(*(class_names(stub, base) for base in bases))


def undocumented(body, prefix=""):
    """Classes, methods and functions without a docstring, and annotated names without a string after them."""
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not ast.get_docstring(node):
            yield prefix + node.name
        if isinstance(node, ast.ClassDef):
            yield from undocumented(node.body, f"{node.name}.")
        if isinstance(node, ast.AnnAssign):
            text = after.value if isinstance(after, ast.Expr) else None
            if not (isinstance(text, ast.Constant) and isinstance(text.value, str)):
                yield prefix + node.target.id


def public(thing):
    """Public names of a module or class as it is."""
    return {name for name in dir(thing) if not name.startswith("_")}


def test_every_member_of_the_core_has_a_sentence():
    """Each class, method, function and number of the contract says what it is."""
    assert list(undocumented(CONTRACT.body)) == []


@pytest.mark.parametrize("name", ["_render", "_surface", "_cpu"])
def test_every_function_of_the_other_stubs_has_a_sentence(name):
    """Each class, method and function says what it does."""
    assert list(undocumented(STUBS[name].body)) == []


def test_a_missing_sentence_is_seen():
    """The reader of docstrings finds a class, a method, a function and a number that have none."""
    text = 'class A:\n    a: int\n    b: int\n    """B."""\n    def f(self): ...\ndef g(): ...\n'
    assert list(undocumented(ast.parse(text).body)) == ["A", "A.a", "A.f", "g"]


@pytest.mark.parametrize("module", [_core, _render, _surface, _cpu], ids=lambda module: module.__name__)
def test_names_of_the_stub_are_those_of_the_module(module):
    """Each public name of a module stands in its stub, and the other way round."""
    stub = STUBS[module.__name__.rpartition(".")[2]]
    only_types = ALIASES.union(PARTS, *PARTS.values())
    assert names_of(stub.body) - only_types == public(module)
    for name in names_of(stub.body) & public(module):
        if isinstance(getattr(module, name), type):
            assert class_names(stub, name) == public(getattr(module, name)), name


@pytest.mark.parametrize(
    ("part", "protocol"),
    [
        (_core.geometry, "Geometry"),
        (_core.heat, "Heat"),
        (_core.f32.ranks, "Ranks"),
        (_core.f64.ranks, "Ranks"),
        (_core.snowfall, "Snowfall"),
        (_core.f32, "Precision"),
        (_core.f64, "Precision"),
    ],
)
def test_names_of_the_contract_are_those_of_the_parts(part, protocol):
    """So it is for the parts of the core, and for the classes that lie in them."""
    assert class_names(CONTRACT, protocol) == public(part)
    for name in PARTS[protocol]:
        assert class_names(CONTRACT, name) == public(getattr(part, name)), name


LENGTHS = {
    "beyond": ("3", 0),
    "modes": ("more_modes", 0),
    "rest": ("4", 0),
    "enthalpy": ("1", 0),
    "thermal": ("3", 0),
}
"""Of fields whose length the scene chooses: its word in the contract, and what it is in a usual scene."""


@pytest.mark.parametrize("field", [*FIELDS, TAU], ids=lambda field: field.name)
def test_a_field_is_as_the_contract_says(precision, field):
    """Shape and type of the array; the unit and the shape stand in the contract."""
    sim = simulate(scene([ball()], precision=precision))
    array = np.asarray(getattr(sim.state, field.name))
    word, length = LENGTHS.get(field.name, ("", 0))
    row = tuple(length if side == "k" else side for side in field.shape)
    assert array.shape == (sim.count, *row)
    assert array.dtype == (precision if field.dtype == "real" else field.dtype)
    text = members("State")[field.name]
    assert f"[{field.unit}]" in text or not field.unit
    shape = ", ".join(word if side == "k" else str(side) for side in field.shape)
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
