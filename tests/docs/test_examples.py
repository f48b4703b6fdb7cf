"""The examples run as they stand, made coarse and short by the changes of values that they take."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE

import neve

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(path for path in (ROOT / "examples").iterdir() if path.name[0].isdigit())
SCRIPTS = [path for path in EXAMPLES if path.suffix == ".py"]
LINES = 80
SHORT = {"04_sweep": ["numerics.dx=0.1"]}
"""Changes that make an example short; of the others, coarse cells and a tenth of a second."""


def numbers(text):
    """The rows of a printed table that hold numbers alone."""
    rows = [line.split() for line in text.splitlines()]
    return np.array([[float(word) for word in row] for row in rows if row and row[0][0].isdigit()])


def first_snowball(place, text):
    """A film is made, and the number of particles told."""
    assert (place / "runs/snowball/preview.mp4").stat().st_size > 1000
    assert re.search(r"[\d,]+ particles, \d+ steps to t = 0\.1 s", text)


def own_scene(place, text):
    """The scene is saved as a file that can be run, and is run."""
    assert neve.load(place / "runs/letters.toml").snow.kind == "packed"
    assert (place / "runs/letters/preview.mp4").exists()


def energy_plot(place, text):
    """A picture is drawn; a snowball in free fall has lost next to nothing."""
    assert (place / "runs/energy.png").stat().st_size > 10_000
    assert re.search(r"^(0% of the energy is lost|the sum of the energies grew by 0\.\d%)", text, re.M)


def sweep(place, text):
    """Snow that hardens more is crushed less: height and J_P grow with xi."""
    xi, height, _, J_P = numbers(text).T
    assert len(xi) == 4
    assert (np.diff([xi, height, J_P], axis=1) > 0).all()


def own_output(place, text):
    """Each table has the frames of its schedule; more snow lies below 99 % of its height than below half."""
    tables = {
        name: np.genfromtxt(place / f"runs/own_output/{name}.csv", delimiter=",", names=True)
        for name in ("height", "middle")
    }
    assert list(tables["height"]["frame"]) == [0, 3]
    assert list(tables["middle"]["frame"]) == [0, 1, 2, 3]
    assert (tables["height"]["height"] > tables["middle"]["height"][::3]).all()


def read_frames(place, text):
    """Time runs from frame to frame; snow that has not been hit is as dense as it was."""
    time, _, density = numbers(text[text.index("time [s]") :]).T
    assert time == pytest.approx([0, 1 / 30, 2 / 30, 0.1], abs=1e-3)
    assert density == pytest.approx(1.0, abs=0.01)


CHECKS = {
    "00_first_snowball": first_snowball,
    "01_own_scene": own_scene,
    "02_energy_plot": energy_plot,
    "04_sweep": sweep,
    "05_own_output": own_output,
    "06_read_frames": read_frames,
}


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_example_runs(path, tmp_path):
    """An example runs in an empty folder and does what its row of the table says."""
    changes = SHORT.get(path.stem, ["numerics.dx=0.1", "run.duration=0.1"])
    done = subprocess.run(
        [sys.executable, str(path), *changes],
        cwd=tmp_path,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
        timeout=PATIENCE,
    )
    assert done.returncode == 0, done.stderr
    CHECKS[path.stem](tmp_path, done.stdout)


def test_examples_are_short_numbered_and_listed():
    """Each has at most 80 lines, a number of its own, and a row of the page in the order of the numbers."""
    assert [
        path.name for path in EXAMPLES if len(path.read_text(encoding="utf-8").splitlines()) > LINES
    ] == []
    assert len({path.name[:2] for path in EXAMPLES}) == len(EXAMPLES)
    page = (ROOT / "examples/README.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| \[(.*?)\]\(\1\)", page, re.M) == [path.name for path in EXAMPLES]
