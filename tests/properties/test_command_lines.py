"""Any list of arguments ends in exit code 0, 1, 2 or 130 and at most one sentence, never in a traceback.

Options come from click's own tables. What takes long stands still: no scene is run, measured or filmed, and
servers end as by Ctrl-C once they listen: the car's has a page here whether or not one was built.
"""

import io
import shutil
import sys
from unittest import mock

import click
import pytest
from hypothesis import given
from hypothesis import strategies as st

import neve
from neve.cli import cli, main
from neve.fuzz.registry import CAMPAIGNS

TINY = """
[numerics]
dx = 0.2
[run]
duration = 0.1
film = false
[[sources]]
shape = "sphere"
radius = 0.2
"""

NUMBERS = [
    "0",
    "1",
    "2",
    "-1",
    "1.5",
    "+1",
    "\u0661",
    "1e308",
    "nan",
    "inf",
    "-inf",
    "0x10",
    "65535",
    "65536",
]
HUGE = ["9" * 18, "9" * 30, "9" * 5000, "0:999999999999999999"]
CHANGES = ["a=b", "=", "snow.xi=3", "numerics.dx=1e-320", "x.y.z=1", "snow=1", "1:2", "2:1", "1:", "65536"]
ODD = [
    "",
    " ",
    "-",
    "--",
    "a\nb",
    "x" * 300,
    "\u2603",
    "\udcff",
    "[",
    "%s",
    "{0}",
    "-x",
    "--no-such",
    "--help",
]
PLACES = ["~", "~nosuchuser", "..", ".", "there/not", "tiny.toml", "tiny", "ran", "ran/log.csv", "ran/frames"]
NAMES = ["empty", "throw_ball", "localhost", "127.0.0.1", "::1", "256.1.1.1", "a..b"]
WORDS = st.sampled_from([*NUMBERS, *HUGE, *CHANGES, *ODD, *PLACES, *NAMES])


def commands():
    """Every command of the command line, groups apart, with the words that name it."""
    for name, command in cli.commands.items():
        if isinstance(command, click.Group):
            yield (name,), command
            yield from (((name, inner), command.commands[inner]) for inner in command.commands)
        else:
            yield (name,), command


COMMANDS = dict(commands())


@st.composite
def lines(draw, words, command):
    """Arguments: options of the command's own table, most with a value, among words."""
    parts = []
    for _ in range(draw(st.integers(0, 4))):
        options = [p for p in command.params if isinstance(p, click.Option)]
        if not options or draw(st.integers(0, 3)) == 0:
            parts.append([draw(WORDS)])
            continue
        option = draw(st.sampled_from(options))
        given = [draw(st.sampled_from(option.opts))]
        takes = not option.is_flag
        if takes != (draw(st.integers(0, 9)) == 0):
            given = [f"{given[0]}={draw(WORDS)}"] if draw(st.booleans()) else [*given, draw(WORDS)]
        parts.append(given)
    for parameter in command.params:
        if isinstance(parameter, click.Argument) and draw(st.integers(0, 4)):
            parts.insert(draw(st.integers(0, len(parts))), [draw(WORDS)])
    return [*words, *[word for part in parts for word in part]]


@pytest.fixture(scope="module")
def ground(tmp_path_factory):
    """A folder with a scene, a finished run of it, and a page."""
    folder = tmp_path_factory.mktemp("ground")
    (folder / "tiny.toml").write_text(TINY)
    neve.Simulation(neve.load(folder / "tiny.toml")).run(folder / "ran", quiet=True)
    (folder / "page").mkdir()
    (folder / "page/index.html").write_text("", encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def still(ground):
    """What takes long is replaced, and the current folder is a copy of `ground` for each line."""
    with (
        mock.patch("neve.run.run_scene"),
        mock.patch("neve.fuzz.run.outcomes", return_value=iter(())),
        mock.patch("neve.validate.run._run", side_effect=KeyboardInterrupt),
        mock.patch("neve.bench.run.Simulation", side_effect=KeyboardInterrupt),
        mock.patch("neve.bench.bodies.Simulation", side_effect=KeyboardInterrupt),
        mock.patch("neve.bench.loose.Simulation", side_effect=KeyboardInterrupt),
        mock.patch("webbrowser.open"),
        mock.patch("neve.cli.commands.tell", side_effect=KeyboardInterrupt),
        mock.patch("neve.drive.serve.PAGE", ground / "page"),
        mock.patch("socketserver.BaseServer.serve_forever", side_effect=KeyboardInterrupt) as served,
    ):
        yield served


def told(arguments):
    """Exit code, output and errors of a command line, through streams as strict as a terminal's."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="strict", write_through=True)
    err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors="backslashreplace", write_through=True)
    with mock.patch.object(sys, "stdout", out), mock.patch.object(sys, "stderr", err):
        try:
            main(arguments)
        except SystemExit as stop:
            code = stop.code
    return code, out.buffer.getvalue().decode(), err.buffer.getvalue().decode()


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_any_arguments_end_well(words, still, ground, tmp_path, monkeypatch):
    """See above; with exit code 2 the sentence is one line, and nothing stands on standard output."""

    @given(lines(words, COMMANDS[words]))
    def holds(arguments):
        place = tmp_path / "here"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(ground, place)
        (place / "empty").mkdir()
        with monkeypatch.context() as patch:
            patch.chdir(place)
            code, out, err = told(arguments)
        assert code in (0, 1, 2, 130), (code, err)
        assert "Traceback" not in err + out
        if code == 2:
            lines = err.splitlines()
            assert [line for line in lines if not line.startswith("neve: ")] == []
            assert len([line for line in lines if not line.startswith("neve: warning: ")]) == 1
            assert out == ""

    holds()
    assert bool(still.called) == (words == ("drive",))
    still.reset_mock()


def test_every_campaign_is_tried():
    """The table of commands sees the groups' own."""
    assert {("fuzz", name) for name in CAMPAIGNS} <= set(COMMANDS)
    assert ("run",) in COMMANDS
