"""What an import may load, and that the tests look at the code that stands here."""

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import neve
import neve.scene

ROOT = Path(__file__).parents[2]
MODULES = sorted((ROOT / "src/neve").rglob("*.py"))
PYDANTIC = {"pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection"}
NEEDED = {"neve", "numpy", "tomli_w", *PYDANTIC}
LISTING = "import json, sys; seen = set(sys.modules); {}; print(json.dumps(sorted(set(sys.modules) - seen)))"


def loaded_by(statement):
    """Top-level modules that a fresh interpreter loads for a statement."""
    command = [sys.executable, "-P", "-c", LISTING.format(statement)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    modules = json.loads(told)
    return {name.partition(".")[0] for name in modules if not name.startswith("_sysconfigdata")}


def test_import_loads_only_what_a_scene_needs():
    """`import neve` loads numpy and pydantic: no image, film, terminal, window or GPU package."""
    extra = loaded_by("import neve; neve.load; neve.Simulation") - NEEDED - set(sys.stdlib_module_names)
    assert extra == set()


def test_names_of_scenes_are_loaded_at_their_first_use():
    """`import neve.scene` loads no pydantic; each name it offers is there, listed, and no other is."""
    assert not {"pydantic", "tomli_w"} & loaded_by("import neve.scene")
    assert set(neve.scene.__all__) <= set(dir(neve.scene))
    assert all(getattr(neve.scene, name).__name__ == name for name in neve.scene.__all__)
    with pytest.raises(AttributeError, match=r"'neve\.scene' has no attribute 'Sauce'"):
        _ = neve.scene.Sauce


def test_import_of_one_module_shows_in_the_listing():
    """The listing above sees a package that is loaded (else it would pass for the wrong reason)."""
    assert "PIL" in loaded_by("import PIL.Image")


def test_installed_package_is_this_checkout():
    """Tests run against the installed package; a stale one would be tested in place of this code."""
    installed = Path(neve.__file__).parent
    kinds = {".py", ".toml", ".typed"}
    here = {p.relative_to(ROOT / "src/neve"): p for p in (ROOT / "src/neve").rglob("*") if p.suffix in kinds}
    differs = [
        str(name)
        for name, path in here.items()
        if not (installed / name).exists() or (installed / name).read_bytes() != path.read_bytes()
    ]
    assert differs == [], "the installed package is not this checkout; run: pip install ."


def taken_from_the_top(path):
    """Names that a module takes from the package itself: `from neve import NAME`, `neve.NAME`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module == "neve":
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "neve":
            yield node.attr


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_module_asks_the_top_for_what_lies_below(path):
    """A module imports others by their own names, so that the import rules see it."""
    below = {p.stem for p in (ROOT / "src/neve").iterdir() if p.is_dir() or p.suffix == ".py"}
    assert (
        set(taken_from_the_top(path))
        - below
        - {"_core", "_cpu", "_render", "_surface", "__path__", "__version__"}
        == set()
    )
