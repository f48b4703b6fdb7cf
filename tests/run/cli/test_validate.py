"""`neve validate`: what passes and fails, the page that holds everything, the same bytes every time."""

import contextlib
import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from patience import PATIENCE, wait_until

from neve.cli import main
from neve.validate import run as running
from neve.validate.registry import CASES, Case
from neve.validate.report.page import page
from neve.validate.result import Check, Curve, Plot, Result, at_least, at_most, band, near


def result(measured=1.01):
    x = np.linspace(0.0, 1.0, 5)
    return Result(
        what="A straight line.",
        equations=("<i>y</i> = <i>x</i>",),
        source="Euclid.",
        checks=(
            Check("slope", np.float64(measured), 1.0, 0.02, "two percent"),
            at_most("loss", 0.1, 0.2, "a bound"),
        ),
        plots=(
            Plot("Line", "x [m]", "y [m]", (band("exact", x, x, 0.02), Curve("measured", x, measured * x))),
        ),
        verdict="It is straight.",
    )


@pytest.fixture
def call(capsys, tmp_path, monkeypatch):
    """Call the command line in an empty folder with two cases that cost nothing: one holds, one does not."""
    monkeypatch.chdir(tmp_path)
    few = {
        "good": Case("good", "A good case", "1", result),
        "bad": Case("bad", "A bad case", "2", lambda: result(1.03)),
    }
    for module in ("run", "report.page"):
        monkeypatch.setattr(f"neve.validate.{module}.CASES", few)

    def line(*arguments):
        with pytest.raises(SystemExit) as stop:
            main(["validate", *arguments])
        told = capsys.readouterr()
        return stop.value.code, told.out, told.err

    return line


def test_checks():
    """Within means either side, up to the tolerance; bounds have one side; NaN never holds."""
    assert near("a", 1.02 - 1e-12, 1.0, 0.02, "").ok
    assert not near("a", 1.021, 1.0, 0.02, "").ok
    assert not near("a", 0.979, 1.0, 0.02, "").ok
    assert near("a", -1.01, -1.0, 0.02, "").ok
    assert at_most("a", 1.0, 1.0, "").ok
    assert not at_most("a", 1.1, 1.0, "").ok
    assert at_least("a", 1.0, 1.0, "").ok
    assert not at_least("a", 0.9, 1.0, "").ok
    assert not Check("a", float("nan"), 1.0, 9.0, "").ok


def test_exit_code_and_progress(call, tmp_path):
    """0 if all hold, 1 if one does not; a line for each case, and what failed by how much."""
    code, out, _ = call("good", "--threads", "1")
    assert code == 0
    assert re.search(r"^good +pass +2 of 2 checks", out, re.M)
    assert (tmp_path / "validation.html").exists()
    code, out, _ = call("--threads", "1", "--out", "other.html")
    assert code == 1
    assert "slope: 1.03 , not 1 +- 0.02" in out
    text = (tmp_path / "other.html").read_text()
    assert "1 of 2 cases hold" in text
    assert text.index("A good case") < text.index("A bad case")


def test_json(call, tmp_path):
    """JSON alone on standard output; the page only where --out asks for it."""
    code, out, err = call("good", "--json", "--threads", "1")
    assert code == 0
    facts = json.loads(out)
    assert facts["good"]["pass"] is True
    assert facts["good"]["checks"][0] == {
        "quantity": "slope", "measured": 1.01, "exact": 1.0, "tolerance": 0.02, "rule": "within", "unit": "",
        "pass": True,
    }  # fmt: skip
    assert "good" in err
    assert not (tmp_path / "validation.html").exists()


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize(("number", "expected"), [(signal.SIGTERM, 143), (signal.SIGKILL, -signal.SIGKILL)])
def test_cases_end_with_the_command(tmp_path, number, expected):
    """A signal to the command alone ends the processes in which it runs cases, however it ends."""
    command = [sys.executable, "-m", "neve.cli", "validate", "--threads", "2", "discs", "repose", "--json"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True
    )
    wait_until(lambda: len(session(process.pid)) >= 3)
    process.send_signal(number)
    told = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == expected
    assert number == signal.SIGKILL or b"Traceback" not in told, told
    wait_until(lambda: not session(process.pid))


def session(leader):
    """The numbers of the processes of a session."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, _, number = stat.read_text().rpartition(")")[2].split()[:4]
            if int(number) == leader and state != "Z":
                found.append(int(stat.parent.name))
    return found


def test_unknown_case(call):
    """One sentence with the nearest name, and exit code 2."""
    assert call("goof") == (2, "", "neve: there is no validation case goof (did you mean good?)\n")


def test_no_matplotlib(call, monkeypatch):
    """Without matplotlib one sentence says what to install, before anything runs; --json alone needs none."""
    monkeypatch.setitem(__import__("sys").modules, "matplotlib", None)
    code, out, err = call("good", "--threads", "1")
    assert (code, out) == (2, "")
    assert "pip install matplotlib" in err
    assert call("good", "--json", "--threads", "1")[0] == 0


def test_page_is_whole_and_the_same():
    """One file: no link but to itself, no script; the same results give the same bytes, whatever the day."""
    name = next(iter(CASES))
    first, again = (page({name: result()}, "1.2.3") for _ in range(2))
    assert first == again
    assert "<script" not in first
    links = re.findall(r'(?:href|src)="([^"]*)"', first)
    assert links
    assert all(link.startswith("#") for link in links)
    assert not re.search(r"20\d\d-\d\d-\d\d", first), "no date"
    assert first.count("<svg") == 1
    assert "1.01" in first
    assert "two percent" in first


def test_cases_are_described():
    """Every case has a name that the command line can take, and a title."""
    assert all(case.name == name and re.fullmatch(r"[a-z_]+", name) for name, case in CASES.items())
    assert len({case.title for case in CASES.values()}) == len(CASES)
    assert running.plain("<i>a</i><sub>b</sub>") == "ab"
