"""Campaigns survive what they look for, go on where they were stopped, and tell everything they saw."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from patience import PATIENCE

from neve.cli import main
from neve.fuzz.outcome import Outcome, outcome_of
from neve.fuzz.registry import CAMPAIGNS, Campaign, named
from neve.fuzz.run import holds, run
from neve.io.errors import RunError

TRIAL = """
import ctypes, os, sys, time
from neve.fuzz.outcome import Outcome

def trial(seed, number):
    print("what a trial prints is no answer")
    os.write(1, b"nor is this\\n")
    if number == 1: ctypes.string_at(0)
    if number == 2: time.sleep(10_000)
    if number == 3: os._exit(7)
    if number == 4: raise ValueError("first line\\nsecond")
    if number == 5: sys.exit("bye")
    if number == 6: return Outcome(seed, number, "refused", "a", "it is too small", facts={"x": float("nan")})
    return Outcome(seed, number, "held", "a")
"""

EXPECTED = {
    0: ("held", ""),
    1: ("failed", "died: killed by SIGSEGV"),
    2: ("failed", "stuck: not done after 1 s"),
    3: ("failed", "died: exit code 7"),
    4: ("failed", "crashed: ValueError: first line second"),
    5: ("failed", "crashed: SystemExit: bye"),
    6: ("refused", "it is too small"),
    7: ("held", ""),
}


@pytest.fixture
def rough(tmp_path, monkeypatch):
    """A campaign whose trials crash, hang and end their process."""
    (tmp_path / "rough.py").write_text(TRIAL)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return Campaign("rough", "a test", "trials", "rough:trial", count=8, limit=PATIENCE)


def test_whatever_a_trial_does_is_its_outcome(rough, capsys, tmp_path):
    """A crash, a hang, an exit and an error each end one trial; the file holds all, and is not run again."""
    out = tmp_path / "out.jsonl"
    assert not run(rough, range(3, 4), only=2, limit=1.0, out=str(out), as_json=True)
    assert not run(rough, range(3, 4), jobs=2, out=str(out), as_json=True)
    told = [outcome_of(line) for line in capsys.readouterr().out.splitlines()]
    found = {outcome.number: (outcome.verdict, outcome.sentence) for outcome in told}
    assert found == EXPECTED
    assert {outcome.seed for outcome in told} == {3}
    head, *lines = out.read_text().splitlines()
    assert json.loads(head)["neve_fuzz"] == "rough"
    assert [outcome_of(line) for line in lines] == told
    assert '"x": "nan"' in out.read_text()
    assert not run(rough, range(3, 4), count=7, out=str(out))  # nothing left to run: at once
    said = capsys.readouterr().out
    assert said.startswith("7 trials: 1 held, 1 refused, 5 failed")
    assert "failed: neve fuzz rough --seed 3 --only 4  (crashed: ValueError: first line second)" in said


def test_a_file_that_was_cut_off_goes_on(rough, tmp_path):
    """The last line of a killed campaign is half: it is dropped, its trial runs again, the file is whole."""
    out = tmp_path / "out.jsonl"
    assert run(rough, only=0, out=str(out))
    whole = out.read_bytes()
    for cut in (len(whole) - 5, whole.index(b"\n") - 3, 0):
        out.write_bytes(whole[:cut])
        assert run(rough, only=0, out=str(out))
        assert [json.loads(line).get("verdict") for line in out.read_text().splitlines()] == [None, "held"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a,b\n1,2\n", "line 1, is no outcome"),
        ("a", "is no file of outcomes"),
        ('{"neve_fuzz": "scenes"}\n', "holds outcomes of neve fuzz scenes"),
        ('{"neve_fuzz": "rough", "code": "0"}\n', "another state of Neve's code"),
        ("[" * 100_000 + "\n", "line 1, is no outcome"),
    ],
)
def test_a_file_of_something_else_is_left_alone(rough, tmp_path, text, words):
    """One sentence, and the file as it was."""
    out = tmp_path / "out.jsonl"
    out.write_text(text)
    with pytest.raises(RunError, match=words):
        run(rough, only=0, out=str(out))
    assert out.read_text() == text


def test_most_refused_is_no_campaign():
    """A campaign whose trials are mostly refused tests nothing, and says so by its exit code."""
    held, refused = Outcome(0, 0, "held"), Outcome(0, 1, "refused")
    assert holds([held, refused] * 20)
    assert not holds([held, refused, refused] * 20)
    assert holds([refused])  # --only
    assert not holds([held, held, Outcome(0, 1, "failed")])


@pytest.mark.parametrize(("number", "expected"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_with_what_was_seen(tmp_path, number, expected):
    """128 + the signal, a summary, no traceback, process or folder left; the file has what was done."""
    command = [sys.executable, "-m", "neve.cli", "fuzz", "--jobs", "1", "--out", "out.jsonl"]
    process = subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, "TMPDIR": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout.readline().startswith("0/0 ")
    time.sleep(0.1)
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == expected
    assert " scenes: " in out
    assert err.lstrip("\n").startswith("neve: stopped: ")  # after the end of the terminal's line of ^C
    assert err.strip("\n").count("\n") == 0
    done = (tmp_path / "out.jsonl").read_text().splitlines()[1:]
    assert f" {len(done)} of 200 scenes are done" in err
    assert [path.name for path in tmp_path.iterdir()] == ["out.jsonl"]


@pytest.mark.parametrize("campaign", CAMPAIGNS.values(), ids=CAMPAIGNS)
def test_campaigns_are_there(campaign):
    """What an entry names can be imported, and a trial has an outcome: the same again, but for its seconds.

    Those of killed runs, which are many processes, depend on when a process was killed.
    """
    trial = named(campaign.trial)
    outcome = trial(5, 53 if campaign.name == "kills" else 0)  # killed once, then hurt; no film
    assert outcome.verdict in ("held", "refused"), outcome
    assert campaign.name == "kills" or trial(5, 0) == outcome
    assert campaign.summary is None or named(campaign.summary)([outcome])


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("--seeds 3", "--seeds: 3 is not of the form A:B"),
        ("--seeds 3:3", "--seeds: 3:3 holds no seed"),
        ("--seeds 1:2 --seed 3", "give one of the two"),
        ("--count 3 --only 1", "give one of the two"),
        ("scenes --limit 0", "--limit: 0.0 is not a time"),
        ("scenes --limit nan", "--limit: nan is not a time"),
        ("scenes --jobs 1000000", "--jobs: 1000000 is more than"),
        ("seens", "there is no command seens (did you mean scenes?)"),
        ("--sede 3", "there is no option --sede (did you mean --seed"),
    ],
)
def test_bad_command_lines(capsys, line, words):
    """Exit code 2 and one sentence."""
    with pytest.raises(SystemExit) as stop:
        main(["fuzz", *line.split()])
    told = capsys.readouterr()
    assert (stop.value.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert words in told.err
