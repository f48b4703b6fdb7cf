"""Run the cells of examples/notebook.ipynb and keep what they print and draw: `python tools/notebook.py`.

It does so without Jupyter, so that neither writing nor testing the notebook needs it. Run it after a change
of the cells.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

NOTEBOOK = Path(__file__).parents[1] / "examples" / "notebook.ipynb"
DPI = 72


def executed(
    notebook: dict[str, Any], names: dict[str, Any]
) -> Iterator[tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Run the code cells of a notebook one after another in the namespace `names`; yield their outputs."""
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec("".join(cell["source"]), names)
        yield cell, [*_text(said.getvalue()), *_figures()]


def _text(said: str) -> Iterator[dict[str, Any]]:
    if said:
        yield {"name": "stdout", "output_type": "stream", "text": said.splitlines(keepends=True)}


def _figures() -> Iterator[dict[str, Any]]:
    """Yield the figures that are open as pictures, and close them."""
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, format="png", dpi=DPI, metadata={"Software": None})
        plt.close(number)
        data = base64.b64encode(picture.getvalue()).decode()
        yield {"data": {"image/png": data}, "metadata": {}, "output_type": "display_data"}


def main() -> None:
    """Write the notebook anew, with its outputs."""
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    home = Path.cwd()
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)  # its runs are not for keeps
        try:
            for number, (cell, outputs) in enumerate(executed(notebook, {"__name__": "__main__"}), 1):
                cell["execution_count"], cell["outputs"] = number, outputs
        finally:
            os.chdir(home)
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print(f"wrote {NOTEBOOK.relative_to(home) if NOTEBOOK.is_relative_to(home) else NOTEBOOK}")


if __name__ == "__main__":
    main()
