"""StageTimer: times add up by stage, also when a block fails, and start again from zero."""

import pytest

from neve import stage_timer
from neve.stage_timer import StageTimer


@pytest.fixture
def ticks(monkeypatch):
    """A clock that is one second later whenever it is read."""
    now = iter(range(1000))
    monkeypatch.setattr(stage_timer.time, "perf_counter", lambda: float(next(now)))


def test_stages_add_up(ticks):
    """Two blocks of one stage take 2 s by the clock, one block of another 1 s, none of the third 0 s."""
    timer = StageTimer(["p2g", "g2p", "sort"])
    for name in ("p2g", "g2p", "p2g"):
        with timer.stage(name):
            pass
    assert timer.seconds == {"p2g": 2.0, "g2p": 1.0, "sort": 0.0}
    assert timer.take() == {"p2g": 2.0, "g2p": 1.0, "sort": 0.0}
    assert timer.take() == {"p2g": 0.0, "g2p": 0.0, "sort": 0.0}


def test_a_failing_block_counts(ticks):
    """The time of a block that raises is counted, and the error passes through."""
    timer = StageTimer()
    with pytest.raises(OSError, match="disk"), timer.stage("write"):
        raise OSError("disk")
    assert timer.seconds == {"write": 1.0}
