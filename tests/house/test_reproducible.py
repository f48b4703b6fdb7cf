"""What results follow from is computed alike on every processor: see `neve.reproducible`."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "src/neve"
ROOMS = ("colliders", "geometry", "mpm", "rigid", "sampling", "scene")
FILES = ("diagnostics.py", "fragments.py", "reproducible.py", "simulation.py", "solver.py")
MODULES = sorted(
    p for p in (*(q for r in ROOMS for q in (ROOT / r).rglob("*.py")), *(ROOT / f for f in FILES))
)

BY_BLAS = {
    "cond",
    "dot",
    "einsum",
    "inner",
    "linalg",
    "matmul",
    "matvec",
    "tensordot",
    "vdot",
    "vecdot",
    "vecmat",
}
BY_VECTOR_CODE = {
    "acos", "arccos", "arccosh", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "asin", "atan", "atan2",
    "cbrt", "cos", "cosh", "exp", "exp2", "expm1", "float_power", "hypot", "log", "log10", "log1p", "log2",
    "polynomial", "pow", "power", "sin", "sinh", "tan", "tanh",
}  # fmt: skip
ELSEWHERE = {("shapes.py", "hypot"), ("fragments.py", "log10")}
"""np.hypot is the C library's own, a root of a sum; the decades of a summary are not written to any file."""


def depends_on_the_processor(text, file=""):
    """Line and name of each operation that NumPy hands to code chosen by the processor."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
            yield node.lineno, "@"
        elif isinstance(node, ast.Attribute) and node.attr == "dot":
            yield node.lineno, "dot"
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "np":
            name = node.attr
            if name in BY_BLAS | BY_VECTOR_CODE and (file, name) not in ELSEWHERE:
                yield node.lineno, f"np.{name}"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_nothing_is_left_to_the_processor(path):
    """No product by BLAS and no function by NumPy's vector code."""
    assert list(depends_on_the_processor(path.read_text(encoding="utf-8"), path.name)) == []


@pytest.mark.parametrize(
    "text", ["a @ b", "a @= b", "a.dot(b)", "np.dot(a, b)", "np.linalg.norm(a)", "np.exp(a)", "f(np.power)"]
)
def test_what_depends_is_seen(text):
    """The reader finds products of every spelling."""
    assert list(depends_on_the_processor(text))
    assert not list(depends_on_the_processor("np.sqrt(np.sum(a * a)) + math.exp(1) + product(a, b)"))
