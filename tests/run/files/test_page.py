"""docs/run_folder.md names what a run folder holds: every file, column and array, in their order."""

import re
import tomllib
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from neve import fragments
from neve.io import log
from neve.io.frames import Frame, make_frame, stored
from neve.io.run_folder import RunFolder
from neve.mpm.time_step import Bound
from neve.run.outputs import solids
from neve.run.outputs.film import FilmOutput
from neve.run.outputs.registry import schedule_of, usual_files
from neve.run.resume import FREE
from neve.scene.reading.load import scene_from

PAGE = (Path(__file__).parents[3] / "docs/run_folder.md").read_text(encoding="utf-8")


def tables():
    """The tables of the page: for each the cells of its rows, without the head."""
    found = [block.splitlines()[2:] for block in PAGE.split("\n\n") if block.startswith("| ")]
    return [[[cell.strip() for cell in row.strip("|").split("|")] for row in rows] for rows in found]


def names(table):
    """The words in code in the first cells of a table."""
    return [name for first, *_ in table for name in re.findall(r"`([^`]+)`", first)]


FILES, LOG, FRAGMENTS, SOLIDS, ARRAYS, COMPACT = tables()


@pytest.mark.parametrize(
    ("table", "columns"),
    [
        (LOG, log.columns("mpm", True, True)),
        (FRAGMENTS, fragments.COLUMNS),
        (SOLIDS, solids.COLUMNS),
        (ARRAYS, [name for name in Frame._fields if name != "more"]),  # what run.fields names
    ],
)
def test_all_columns_stand_in_the_page(table, columns):
    """Each column and array has its place, and a meaning in the last cell of its row."""
    assert tuple(names(table)) == tuple(columns)
    assert all(row[-1] for row in table)


def test_arrays_of_compact_frames_stand_in_the_page():
    """Each array of a compact frame is named, or stands as NAME with one of the ends that the page names."""
    n = 64
    x, ids = np.zeros((n, 3)), np.arange(n, dtype=np.uint32)
    more = {"m": np.ones(n), "V0": np.ones(n), "tau": np.full((n, 6), 1e6), "source": np.zeros(n, np.uint16)}
    content = make_frame(x, x, np.ones(n), ids, np.zeros(n, np.uint16), [(x[0], np.eye(3))], 0.0, more)
    words = {word for row in COMPACT for cell in row for word in re.findall(r"`([^`]+)`", cell)}
    whole = "material", "source", "id"
    known = {
        *words,
        "tau",
        "tau_scale",
        *(f"{name}{end}" for name in whole for end in ("_values", "_counts")),
    }
    assert {"NAME_scale", "NAME_values", "NAME_counts"} <= words
    assert set(stored(content, 0.4)) <= known
    assert set(names(COMPACT)) >= {name for name in Frame._fields if name != "more"}


def test_all_files_stand_in_the_page():
    """Each file that a run or an output writes is named, and none else; parts of a film with the film."""
    folder = RunFolder("run")
    known = {path.name for path in vars(folder).values()} - {"run"}
    assert set(names(FILES)) == known | usual_files()
    assert "`.preview.mp4.parts`" in PAGE


def test_words_of_the_page():
    """What may bound a step, and what a resume may change, are the words of the code."""
    [row] = [row for row in LOG if row[0] == "`bound`"]
    assert set(get_args(Bound)) == set(re.findall(r"`(\w+)`", row[-1]))
    for key in FREE:
        assert f"`{key}`" in PAGE
    assert f"{fragments.MOST} largest fragments" in PAGE


def test_list_of_outputs_of_the_page():
    """The list that the page shows is one that a scene may have, and writes what the page says."""
    [text] = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    scene = scene_from(tomllib.loads(f'{text}\n[[sources]]\nshape = "sphere"\n'))
    frames, film = scene.outputs
    assert (frames.file(), film.file()) == ("frames", "side.mp4")
    due = [k for k in range(31) if schedule_of(film, FilmOutput(), scene.run.fps).due(k)]
    assert due == list(range(0, 31, 3))
