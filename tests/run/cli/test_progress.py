"""Progress: a bar on a terminal, plain lines elsewhere, silence if wished; and schedules."""

import io
import logging

import pytest

from neve.run.progress import Bar, Lines, Pace, Silence, Warnings, duration, follow, warnings_to


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self):
        return True


class Clock:
    """A clock that is set by hand."""

    now = 100.0

    def __call__(self):
        return self.now


def test_the_stream_decides():
    """A terminal gets a bar, a file gets lines, quiet gets nothing."""
    assert isinstance(follow("ball", 0, 9, stream=Terminal()), Bar)
    assert isinstance(follow("ball", 0, 9, stream=io.StringIO()), Lines)
    assert isinstance(follow("ball", 0, 9, quiet=True, stream=Terminal()), Silence)


def test_warnings_alone():
    """Without progress what is logged still goes out, a line each, in the style of the command line."""
    stream = io.StringIO()
    with Warnings(stream) as shown, warnings_to(shown):
        shown.update(3, 1, 40)
        logging.getLogger("neve.some.module").warning("snow is %s", "warm")
    assert stream.getvalue() == "neve: warning: snow is warm\n"


def test_lines_come_every_few_seconds():
    """The first frame, one every five seconds, and the last: with pace and time left."""
    clock, stream = Clock(), io.StringIO()
    with Lines("ball", 0, 10, stream, clock=clock) as lines:
        for frame in range(11):
            lines.update(frame, 12345, 40 * frame)
            clock.now += 2.0
        lines.say("done")
    assert stream.getvalue().splitlines() == [
        "ball: frame 0 of 10, 12,345 particles",
        "ball: frame 3 of 10, 12,345 particles, 20 steps/s, 14 s left",
        "ball: frame 6 of 10, 12,345 particles, 20 steps/s, 8 s left",
        "ball: frame 9 of 10, 12,345 particles, 20 steps/s, 2 s left",
        "ball: frame 10 of 10, 12,345 particles, 20 steps/s",
        "done",
    ]


def test_pace_of_a_resumed_run():
    """Frames and steps from before the resume do not count as fast ones."""
    clock = Clock()
    pace = Pace(50, 100, clock)
    pace.update(50, 2000)
    clock.now += 10.0
    pace.update(60, 2400)
    assert (pace.steps_per_second, pace.seconds_left) == (40.0, 40.0)


def test_bar_shows_frames_and_particles():
    """The bar names run, frame, particles and pace, and prints sentences above itself."""
    stream = Terminal()
    with follow("[ball]", 0, 2, stream=stream) as bar:
        bar.update(0, 777, 0)
        bar.update(2, 777, 90)
        bar.say("all [done]")
    shown = stream.getvalue()
    assert all(
        words in shown for words in ("[ball]", "frame 2 of 2", "777 particles", "steps/s", "all [done]")
    )


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.4, "0 s"), (59.4, "59 s"), (59.6, "1:00 min"), (187, "3:07 min"), (7500, "2:05 h")],
)
def test_duration(seconds, words):
    """Time spans read like a clock."""
    assert duration(seconds) == words


def test_warnings_that_say_the_same_are_counted():
    """Of forty that differ in numbers and parts three are shown, and the others counted at the end."""
    stream = io.StringIO()
    with Warnings(stream) as shown, warnings_to(shown):
        for i in range(40):
            logging.getLogger("neve").warning("snow of sources.%d is pressed to %d kg/m3", i, 950 + i)
        for _ in range(5):
            logging.getLogger("neve").warning("the disk is nearly full")
    lines = stream.getvalue().splitlines()
    assert lines[:3] == [
        f"neve: warning: snow of sources.{i} is pressed to {950 + i} kg/m3" for i in range(3)
    ]
    assert lines[3:] == [
        "neve: warning: the disk is nearly full",
        "neve: warning: snow of sources.0 is pressed to 950 kg/m3 (and likewise 37 others)",
        "neve: warning: the disk is nearly full (and likewise 4 others)",
    ]
