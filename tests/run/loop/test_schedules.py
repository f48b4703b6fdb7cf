"""Schedules: when something is due, by frames, by simulated time and by wall time."""

from fractions import Fraction
from itertools import pairwise

import pytest

from neve.schedule import EveryFrames, EverySeconds, EveryWallSeconds, Never, Regular


def test_frames():
    """Every n-th frame from 0 on; n / fps seconds lie between two."""
    assert [k for k in range(10) if EveryFrames(3).due(k)] == [0, 3, 6, 9]
    assert all(EveryFrames().due(k) for k in range(10))
    assert EveryFrames(3).interval(30) == Fraction(1, 10)
    with pytest.raises(ValueError, match="1 or more"):
        EveryFrames(0)


@pytest.mark.parametrize(("seconds", "fps"), [(0.1, 30), (0.25, 30), (0.07, 50), (1 / 3, 24), (2.0, 3)])
def test_simulated_time(seconds, fps):
    """Each multiple of the time has exactly one frame, the first at or after it, in exact decimal numbers."""
    step = Fraction(repr(seconds))
    due = [k for k in range(1000) if EverySeconds(seconds, fps).due(k)]
    expected = [-(-step * j * fps // 1) for j in range(len(due))]
    assert due == expected
    assert len(due) == 999 // (fps * step) + 1
    assert all(a < b for a, b in pairwise(due))


def test_a_tenth_is_every_third_of_thirty():
    """0.1 s is 3 frames of 1/30 s although 0.1 has no exact binary form, in an hour of simulated time too."""
    timed = EverySeconds(0.1, 30)
    assert all(timed.due(k) == (k % 3 == 0) for k in [*range(100), *range(107900, 108100)])
    with pytest.raises(ValueError, match="greater than 0"):
        EverySeconds(float("nan"), 30)


def test_wall_time():
    """Due at the first frame, then at the first one that is 3 s later by the clock."""
    now = [0.0]
    timed = EveryWallSeconds(3.0, lambda: now[0])
    due = []
    for frame in range(6):
        due.append(timed.due(frame))
        now[0] += 1.5
    assert due == [True, False, True, False, True, False]
    assert not Never().due(5)
    with pytest.raises(ValueError, match="0 s or more"):
        EveryWallSeconds(float("nan"))


def test_what_takes_long_is_due_less_often():
    """What takes 0.05 s may take a hundredth of the time every 5 s; the longest wait is a minute."""
    now = [0.0]
    timed = EveryWallSeconds(3.0, lambda: now[0], share=0.01, most=60.0)

    def waits():
        timed.due(0)
        start, now[0] = now[0], now[0] + 0.5
        while not timed.due(0):
            now[0] += 0.5
        return now[0] - start

    for took, wait in ((0.0, 3.0), (0.05, 5.0), (2.0, 60.0), (0.001, 3.0)):
        timed.took(took)
        assert waits() == wait


def test_only_regular_schedules_have_an_interval():
    """Wall time has none: how often it is due differs from run to run."""
    assert isinstance(EveryFrames(2), Regular)
    assert isinstance(EverySeconds(0.1, 30), Regular)
    assert not isinstance(EveryWallSeconds(3.0), Regular)
