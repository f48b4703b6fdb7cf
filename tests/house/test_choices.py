"""A choice stands in one place: its word occurs where it is defined and in the list that names it.

Looked at are the core, the package and the page; left out are what speaks of single choices as tests do
(known answers), and what makes scenes (benchmarks, random scenes, presets, named snows).
"""

import re
from functools import cache
from pathlib import Path

import pytest

from neve.run.outputs.registry import BUILT_IN
from neve.scene.schema.file_shapes import Layer
from neve.scene.schema.shapes import FORMULAS
from neve.scene.values.choices import LAWS, SPLINES, TRANSFERS

ROOT = Path(__file__).parents[2]
SUFFIXES = {".hpp", ".cpp", ".py", ".pyi", ".js"}
LEFT_OUT = ("assets", "bench", "fuzz", "validate", "scene/presets", "drive/page")

OTHER_MEANINGS = {"pic", "flip", "quadratic", "cubic"}
"""Words that the code uses in another sense too: they count in quotes alone."""


@cache
def sources(*folders):
    """Path -> text of the source files in these folders, without includes: a path is no word."""
    files = [path for folder in folders for path in (ROOT / folder).rglob("*") if path.suffix in SUFFIXES]
    kept = [path for path in files if not path.is_relative_to(ROOT / "src/neve") or not left_out(path)]
    return {path: re.sub(r"^#include .*", "", path.read_text(encoding="utf-8"), flags=re.M) for path in kept}


def left_out(path):
    """Whether the file lies in a folder that is left out."""
    inside = path.relative_to(ROOT / "src/neve").as_posix()
    return inside.startswith(tuple(f"{folder}/" for folder in LEFT_OUT))


def holding(word, texts, quoted):
    """The files that hold the word, in quotes or anywhere."""
    pattern = re.compile(rf"[\"']{word}[\"']" if quoted else rf"(?<![\w-]){word}(?![\w-])")
    return sorted(path.relative_to(ROOT).as_posix() for path, text in texts.items() if pattern.search(text))


@pytest.mark.parametrize("word", [*LAWS, *TRANSFERS, *SPLINES])
def test_a_law_a_transfer_and_a_spline_stand_in_two_files(word):
    """Two: where it is defined, and one more for what is built on it."""
    found = holding(word, sources("core", "src/neve"), quoted=word in OTHER_MEANINGS)
    assert 1 <= len(found) <= 2, found


@pytest.mark.parametrize("word", [shape.model_fields["shape"].default for shape in (*FORMULAS, Layer)])
def test_a_shape_stands_in_four_files(word):
    """Four: its class, its distance in the core, and two for what only this shape can do."""
    texts = {path: text for path, text in sources("core", "src/neve").items() if path.suffix != ".js"}
    found = holding(word, texts, quoted=True)
    assert 1 <= len(found) <= 4, found


@pytest.mark.parametrize("word", BUILT_IN)
def test_an_output_stands_in_its_file_and_the_registry(word):
    """Of the files about runs."""
    found = holding(word, sources("src/neve/run"), quoted=True)
    assert found == sorted([f"src/neve/run/outputs/{word}.py", "src/neve/run/outputs/registry.py"])


def test_a_word_in_a_third_file_is_found():
    """The count would see a list written by hand; a path is no word, nor is a part of one."""
    texts = {ROOT / name: text for name, text in (("a", 'x = "apic"'), ("b", "polyapic"), ("c", "# apic"))}
    assert holding("apic", texts, quoted=False) == ["a", "c"]
    assert holding("apic", texts, quoted=True) == ["a"]
