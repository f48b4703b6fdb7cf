"""The notebook: its cells run as they stand, made coarse and short, and it holds what they print and draw."""

import base64
import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scripts import script

NOTEBOOK = Path(__file__).parents[2] / "examples/notebook.ipynb"
SHORT = {
    "DX = 0.08": "DX = 0.15",
    "FRAMES = 27": "FRAMES = 9",
    "radius=0.08": "radius=0.15",
    "(4.0, 8.0, 16.0)": "(4.0, 16.0)",
}
"""What makes the cells short."""


@pytest.fixture
def notebook():
    return json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def code(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def test_its_cells_run(notebook, tmp_path, monkeypatch):
    """Without Jupyter: energy is lost at the ground, a plate bears the weight, faster snow spreads more."""
    monkeypatch.chdir(tmp_path)
    text = "".join("".join(cell["source"]) for cell in code(notebook))
    assert all(word in text for word in SHORT)
    for cell in code(notebook):
        for old, new in SHORT.items():
            cell["source"] = [line.replace(old, new) for line in cell["source"]]
    names = {}
    with script("tools", "notebook") as tool:
        shown = [outputs for _, outputs in tool.executed(notebook, names)]
    pictures = [[o for o in outputs if o["output_type"] == "display_data"] for outputs in shown]
    assert [len(of_cell) for of_cell in pictures] == [0, 0, 1, 1, 1, 0]
    assert plt.get_fignums() == []
    assert 0.5 < 1 - names["total"][-1] / names["total"][0] < 1
    assert np.mean(names["force"][30:]) == pytest.approx(names["weight"], rel=0.02)
    slow, fast = names["spread"]
    assert fast > 1.2 * slow
    assert len(list(Path("runs/notebook/frames").glob("*.npz"))) == 10


def test_it_holds_what_its_cells_show(notebook):
    """Every cell was run, in order; pictures are pictures, and the file is small."""
    assert [cell["execution_count"] for cell in code(notebook)] == list(range(1, len(code(notebook)) + 1))
    outputs = [output for cell in code(notebook) for output in cell["outputs"]]
    drawn = [output["data"]["image/png"] for output in outputs if output["output_type"] == "display_data"]
    assert len(drawn) == 3
    assert all(base64.b64decode(picture).startswith(b"\x89PNG") for picture in drawn)
    assert NOTEBOOK.stat().st_size < 300_000
