"""A shape is written once on each side: in Python, in the core, and in the pictures of both."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("core", "src/neve")
SCENES = ("src/neve/scene/presets", "src/neve/assets", "src/neve/validate", "src/neve/bench", "src/neve/fuzz")
"""Scenes, and cases that are scenes: they use shapes and list none."""
BUILT = "src/neve/drive/page"
"""What web/drive builds, where it was built."""
SOURCES = {".py", ".pyi", ".hpp", ".cpp", ".js"}


def test_a_shape_is_named_in_four_files():
    """The cylinder stands for all: its word is not used for anything else.

    Its class, its distance, where rays enter it, and its triangles for the page.
    """
    found = {
        str(path.relative_to(ROOT))
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.suffix in SOURCES and not str(path.relative_to(ROOT)).startswith((*SCENES, BUILT))
        if "cylinder" in path.read_text(encoding="utf-8").lower()
    }
    assert found == {
        "core/geometry/shape_rays.hpp",
        "core/geometry/shapes.hpp",
        "src/neve/scene/schema/shapes.py",
        "src/neve/viewer/page/draw/meshes.js",
    }
