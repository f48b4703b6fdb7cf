"""Files that the mutator has damaged are read or refused in one sentence; what is not is seen."""

import warnings

import numpy as np
import pytest

from neve.fuzz.files import trial
from neve.fuzz.files.corpus import corpus
from neve.fuzz.files.mutate import LARGEST, damaged
from neve.scene.errors import SceneError

COUNT = 6
"""Files of each kind."""


@pytest.mark.parametrize("kind", corpus())
def test_whole_files_are_read(kind, tmp_path):
    """What is damaged afterwards is right before."""
    for number, content in enumerate(corpus()[kind]):
        path = tmp_path / f"{number:06d}.{kind}"
        path.write_bytes(content)
        assert trial._attempt(trial.READERS[kind], path) == ("", "")


def test_damaged_files_are_read_or_told():
    """A few files of every kind from a seed of their own."""
    outcomes = [trial.read_damaged(2015, number) for number in range(COUNT * len(corpus()))]
    assert [f"{o.number}: {o.sentence}" for o in outcomes if o.verdict != "held"] == []
    assert {o.facts["kind"] for o in outcomes if o.facts["told"]} == set(corpus())
    assert any(not o.facts["told"] for o in outcomes)
    assert "ttf" in trial.summary(outcomes)


def test_damage_follows_from_the_seed_and_changes_files():
    """Equal seeds damage alike; hardly a file stays as it is; none grows without bound."""
    whole = corpus()["obj"][0]

    def all_of(seed):
        return [damaged(whole, whole, np.random.default_rng([seed, n])) for n in range(200)]

    assert all_of(0) == all_of(0)
    assert all_of(0) != all_of(1)
    assert sum(content != whole for content in all_of(0)) > 180
    assert max(map(len, all_of(0))) <= LARGEST


def raising(error):
    """A reader that raises."""

    def read(path):
        raise error

    return read


def warning(path):
    """A reader at which NumPy warns."""
    warnings.warn("overflow encountered", RuntimeWarning, stacklevel=1)


@pytest.mark.parametrize(
    ("reader", "fault"),
    [
        (raising(ZeroDivisionError("by zero")), "ZeroDivisionError in test_damaged_files.py:"),
        (raising(MemoryError()), "MemoryError"),
        (raising(SceneError("invalid outline")), "not one sentence that names the file"),
        (warning, "warned: RuntimeWarning: overflow"),
    ],
)
def test_what_is_no_sentence_is_a_fault(reader, fault, tmp_path):
    """Tracebacks, sentences without a file, two lines, and warnings of libraries."""
    assert fault in trial._attempt(reader, tmp_path / "000001.toml")[0]
