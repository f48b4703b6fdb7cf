"""The worked example of a law of one's own: a copy of the tree gets what the page shows, is built and run."""

import importlib.util
import os
import re
import shlex
import shutil
import site
import subprocess
import sys
from pathlib import Path

import pytest
from documented import FENCE

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "examples/03_own_law.md").read_text(encoding="utf-8")
COMPILER = next((p for p in map(shutil.which, [os.environ.get("CXX", ""), "c++"]) if p), None)


def steps():
    """What the page does to files: (path, kind of block, block); the text before a block names its path."""
    path = None
    for before, kind, block in zip(*[iter(FENCE.split(PAGE)[:-1])] * 3, strict=True):
        named = re.findall(r"`(core/\S+?\.hpp)`", before)
        path = named[-1] if named else path
        if kind in ("cpp", "diff"):
            yield path, kind, block


def apply(tree):
    """Write the new files into the copy of the tree and replace the lines of each difference."""
    for path, kind, block in steps():
        file = tree / path
        if kind == "cpp":
            assert not file.exists()
            file.write_text(block, encoding="utf-8")
            continue
        lines = block.splitlines(keepends=True)
        old, new = ("".join(line[1:] for line in lines if line[0] in kept) for kept in (" -", " +"))
        text = file.read_text(encoding="utf-8")
        assert text.count(old) == 1, (path, old)
        file.write_text(text.replace(old, new), encoding="utf-8")


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the tree with the law, its core built without optimization."""
    for module, program in (("nanobind", "cmake"), (None, "ninja")):
        if module and not importlib.util.find_spec(module):
            pytest.skip(f"{module} is not installed, which compiling needs (pip install {module})")
        if not shutil.which(program):
            pytest.skip(f"there is no {program}, which compiling needs")
    if not COMPILER:
        pytest.skip("there is no C++ compiler")
    import neve._render
    import neve._surface

    tree = tmp_path_factory.mktemp("tree")
    shutil.copy(ROOT / "CMakeLists.txt", tree)
    shutil.copytree(ROOT / "core", tree / "core")
    built = shutil.ignore_patterns("_core.*.so", "_core.*.dylib", "builds", "__pycache__", "page")
    shutil.copytree(ROOT / "src/neve", tree / "src/neve", ignore=built)
    for module in (neve._render, neve._surface):  # what draws knows of no law
        shutil.copy(module.__file__, tree / "src/neve")
    apply(tree)
    cache = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    quick = [
        "-DCMAKE_BUILD_TYPE=Debug",
        "-DCMAKE_CXX_FLAGS_DEBUG=-O0",
        f"-DPython_EXECUTABLE={sys.executable}",
    ]
    for command in (
        [
            "cmake",
            "-S",
            ".",
            "-B",
            "build",
            "-G",
            "Ninja",
            f"-DCMAKE_CXX_COMPILER={COMPILER}",
            *quick,
            *cache,
        ],
        ["cmake", "--build", "build", "--target", "_core"],
    ):
        done = subprocess.run(command, cwd=tree, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    return tree


def python(tree, *words):
    """Run Python on the copy: without .pth files, so that no installed Neve stands before it."""
    paths = os.pathsep.join([str(tree / "src"), *site.getsitepackages()])
    command = [sys.executable, "-S", *words]
    done = subprocess.run(
        command,
        cwd=tree,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_law_is_one_file_and_one_list():
    """The page makes one new file and changes no file but the list of laws."""
    made = [path for path, kind, _ in steps() if kind == "cpp"]
    changed = {path for path, kind, _ in steps() if kind == "diff"}
    assert len(made) == 1
    assert changed == {"core/constitutive/laws.hpp"}


def test_stress_is_the_derivative_of_energy(tree):
    """The page's own Python: central differences of Psi in float64, whose error is h^2 / 6 of Psi'''."""
    code = [block for kind, block in FENCE.findall(PAGE) if kind == "python"]
    where = "\nimport neve\nprint(neve.__file__)"
    assert python(tree, "-c", code[0] + where).startswith(str(tree))


def test_a_scene_runs_with_the_law(tree):
    """A tenth of a second of the page's run; the scene format and random scenes know the law at once."""
    (words,) = re.findall(r"`neve (run [^`]*)`", PAGE)
    short = (
        "--set run.duration=0.1 --set numerics.dx=0.12 --set run.film=false --out made --quiet --threads 1"
    )
    python(tree, "-m", "neve.cli", *shlex.split(words), *short.split())
    assert 'law = "st_venant_kirchhoff"' in (tree / "made/scene.toml").read_text(encoding="utf-8")
    drawn = "from neve.fuzz.scenes import draw; print({draw(0, k)[0].snow.law for k in range(60)})"
    assert "st_venant_kirchhoff" in python(tree, "-c", drawn)
