"""What an import may load, and that the tests look at the code that stands here."""

import json
import subprocess
import sys
from pathlib import Path

import neve

ROOT = Path(__file__).parents[2]
NEEDED = {
    "neve",
    "numpy",
    "pydantic",
    "pydantic_core",
    "annotated_types",
    "typing_extensions",
    "typing_inspection",
}
LISTING = "import json, sys; seen = set(sys.modules); {}; print(json.dumps(sorted(set(sys.modules) - seen)))"


def loaded_by(statement):
    """Top-level modules that a fresh interpreter loads for a statement."""
    command = [sys.executable, "-P", "-c", LISTING.format(statement)]
    modules = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return {name.partition(".")[0] for name in modules}


def test_import_loads_only_what_a_scene_needs():
    """`import neve` loads numpy and pydantic: no image, film, terminal, window or GPU package."""
    extra = loaded_by("import neve; neve.load; neve.Simulation") - NEEDED - set(sys.stdlib_module_names)
    assert extra == set()


def test_import_of_one_module_shows_in_the_listing():
    """The listing above sees a package that is loaded (else it would pass for the wrong reason)."""
    assert "PIL" in loaded_by("import PIL.Image")


def test_installed_package_is_this_checkout():
    """Tests run against the installed package; a stale one would be tested in place of this code."""
    installed = Path(neve.__file__).parent
    kinds = {".py", ".toml", ".typed"}
    here = {p.relative_to(ROOT / "neve"): p for p in (ROOT / "neve").rglob("*") if p.suffix in kinds}
    differs = [
        str(name)
        for name, path in here.items()
        if not (installed / name).exists() or (installed / name).read_bytes() != path.read_bytes()
    ]
    assert differs == [], "the installed package is not this checkout; run: pip install ."
