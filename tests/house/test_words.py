"""Words: docstrings of what is public, one version everywhere, nothing about a machine."""

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SKIPPED = {".git", "build", "dist", "runs", "__pycache__", ".venv", "node_modules"}
CODE = {".py", ".hpp", ".cpp", ".js", ".ts", ".html", ".css", ".cmake"}
TEXT = {".toml", ".md", ".txt", ".cff", ".csv", ".bib", ""} | CODE
PLACES = re.compile(
    r"(?<![\w.])/(?:home|root|Users|work|opt|tmp|mnt|scratch)/|[A-Z]:\\Users|index-url|localhost:"
)
FORMER = re.compile(
    r"\b(?:careful_step|is_bold|Taken|refusals|Ahead|leap|squeeze|culprit|complaints?|Yielding|Ledger|wish)\b"
)
"""Names that were replaced by plainer ones."""


def texts():
    """All text files of the repository, without build products and hidden caches."""
    for path in sorted(ROOT.rglob("*")):
        parts = path.relative_to(ROOT).parts
        hidden = any(part.startswith(".") and part != ".ci" for part in parts[:-1])
        made = parts[0].startswith("build-") or parts[:4] == ("src", "neve", "drive", "page")
        built = made or SKIPPED & set(parts)
        if path.is_file() and path.suffix in TEXT and not hidden and not built:
            yield path


def without_docstring(tree, public=True):
    """Names of public modules, classes, functions and methods that say nothing about themselves."""
    if ast.get_docstring(tree) is None:
        yield getattr(tree, "name", "module")
    for node in tree.body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            if isinstance(node, ast.ClassDef):
                yield from without_docstring(node)
            elif ast.get_docstring(node) is None and not is_overload(node):
                yield f"{getattr(tree, 'name', '')}.{node.name}".lstrip(".")


def is_overload(node):
    return any(ast.unparse(decorator).endswith(("overload", ".setter")) for decorator in node.decorator_list)


@pytest.mark.parametrize(
    "path", sorted((ROOT / "src/neve").rglob("*.py")), ids=lambda p: str(p.relative_to(ROOT))
)
def test_public_names_have_docstrings(path):
    """Each public module, class, function and method of the package says what it does."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert not tree.body or list(without_docstring(tree)) == []


def test_no_file_names_a_machine():
    """No text file holds an absolute path of somebody's machine or a package host."""
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for path in texts()
        if path != Path(__file__)
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1)
        if PLACES.search(line)
    ]
    assert found == []


def test_replaced_names_stay_away():
    """No code of the package or the core goes back to a name that was replaced."""
    found = [
        f"{path.relative_to(ROOT)}: {name}"
        for folder in ("src", "core")
        for path in texts()
        if path.is_relative_to(ROOT / folder) and path.suffix in CODE
        for name in FORMER.findall(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_one_version_everywhere():
    """pyproject.toml, CITATION.cff and the newest entry of the changelog name the same version."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    cited = re.search(r"^version: *\"?([\w.]+)", (ROOT / "CITATION.cff").read_text(), re.M)
    changed = re.findall(r"^## \[(\d[\w.]*)\]", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert [cited and cited.group(1), changed[0]] == [version, version]
