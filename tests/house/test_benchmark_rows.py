"""Rows of measured figures have a column for each stage, and the files have the columns that are written."""

import csv
from pathlib import Path

import pytest
from scripts import script

from neve.mpm.step import STAGES

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def to_csv():
    """The script that appends rows."""
    with script("benchmarks", "to_csv") as module:
        yield module


def test_each_stage_has_a_column(to_csv):
    """`neve bench` reports the stages of the step and the rest, and each is kept."""
    assert {f"{stage}_ms" for stage in (*STAGES, "other")} <= set(to_csv.COLUMNS)


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("results/*.csv")), ids=lambda path: path.name)
def test_files_have_these_columns(to_csv, path):
    """A file that is appended to has the columns of its new rows."""
    with open(path, newline="", encoding="utf-8") as file:
        assert next(csv.reader(file)) == to_csv.COLUMNS
