"""The comparison with peers: its table, a peer that cannot be installed, and peers that run or fail to."""

import csv
import io
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from scripts import script

PROGRAMS = {
    "neve_again": "from neve_snow import Program",
    "other_work": (
        "import neve_snow\n"
        "class Program(neve_snow.Program):\n"
        "    def state(self):\n"
        "        x, v, J_P = super().state()\n"
        "        return x + 0.1, v, J_P\n"
    ),
    "fails": "raise ImportError('no module named | snow')",
}


@pytest.fixture(scope="module")
def runner():
    """The script that measures."""
    with script("benchmarks/peers", "run") as module:
        yield module


@pytest.fixture(scope="module")
def table():
    """What writes the table."""
    with script("benchmarks/peers", "table") as module:
        yield module


@pytest.fixture(scope="module")
def peers():
    """The list of peers."""
    with script("benchmarks/peers", "peers") as module:
        yield module


@pytest.fixture
def options(runner, tmp_path):
    """Options of a short run."""
    words = ["--batches", "1", "--steps", "2", "--threads", "1", "--limit", "300"]
    found = runner.parsed([*words, "--folder", str(tmp_path)])
    found.dx = 0.02
    return found


def row_of_program(runner, peers, options, tmp_path, monkeypatch, program, same_step=True):
    """The row of one of PROGRAMS on a block of 512 particles, run by this interpreter."""

    @dataclass(frozen=True)
    class Here(peers.Peer):
        def python(self, folder, seconds):
            return Path(sys.executable)

    (tmp_path / f"{program}.py").write_text(PROGRAMS[program], encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    with script("benchmarks/peers", "work") as work:
        work.case_of((4, 4, 4)).save(tmp_path / "case.npz")
    peer = Here(program, program, same_step=same_step, note="a copy")
    (row,) = runner.rows_of([peer], tmp_path / "case.npz", options)
    return row


def test_rows_are_written_with_what_they_share(table):
    """A line of CSV for each row, a line of Markdown, and no mark of the table within a cell."""
    about = table.About("2026-01-02", "two cores", "0.1.0", "3.11", "python run.py")
    rows = [
        table.Row(
            "a", "1.0", "law", "float32", 1234567, 0.02, 1e-4, 2, "cpu", 2.5, 5.0, 0.25, 20.0, 19.0, 21.0
        ),
        table.Row("b", note="it cannot run: this | that"),
    ]
    first, second = csv.DictReader(io.StringIO(table.as_csv(about, rows)))
    assert first["hardware"] == second["hardware"] == "two cores"
    assert (first["particles"], first["rate"], first["ratio"]) == ("1234567", "2.5", "20")
    assert second["rate"] == ""
    assert second["note"] == "it cannot run: this | that"
    lines = table.as_markdown(about, rows).splitlines()
    assert lines[0] == "2026-01-02, two cores, Neve 0.1.0, Python 3.11: `python run.py`"
    assert "| a 1.0 | law | float32 | 1,234,567 | 0.02 | 0.0001 | 2 | 2.5 | 5 | 20 (19-21) |" in lines[4]
    assert len({line.count("|") for line in lines[2:]}) == 1


def test_what_cannot_be_installed_is_a_row(runner, peers, options, tmp_path, monkeypatch):
    """Its environment is made, pip refuses the package, and the reason is the note."""
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    peer = peers.Peer("ghost", "ghost_snow", (str(tmp_path / "nowhere"),))
    (row,) = runner.rows_of([peer], tmp_path / "case.npz", options)
    assert row.peer == "ghost"
    assert row.rate is None
    assert row.note.startswith("cannot be installed: ERROR:")
    assert not (tmp_path / "ghost" / "ready.txt").exists()


def test_installed_environment_is_kept(peers, tmp_path):
    """What is ready is not made again."""
    peer = peers.Peer("here", "here_snow", ("a", "b"))
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "ready.txt").write_text("a\nb", encoding="utf-8")
    assert peer.python(tmp_path, 1.0).parent.parent == tmp_path / "here"


def test_same_step_gets_its_numbers(runner, peers, options, tmp_path, monkeypatch):
    """Neve against itself: the particles of the block, as many steps, a rate and a ratio."""
    row = row_of_program(runner, peers, options, tmp_path, monkeypatch, "neve_again")
    assert row.note == "a copy"
    assert (row.particles, row.threads, row.dt) == (512, 1, 1e-4)
    assert row.rate * 1e6 * row.wall * row.dt == pytest.approx(row.particles)
    assert row.least <= row.ratio <= row.largest


def test_other_work_gets_none(runner, peers, options, tmp_path, monkeypatch):
    """A peer whose snow ends elsewhere has no numbers, if it claims to take the same step."""
    row = row_of_program(runner, peers, options, tmp_path, monkeypatch, "other_work")
    assert row.rate is None
    assert row.note.startswith("it does not do the same work: mean z [m] is ")
    row = row_of_program(runner, peers, options, tmp_path, monkeypatch, "other_work", same_step=False)
    assert row.rate > 0


def test_what_cannot_run_says_why(runner, peers, options, tmp_path, monkeypatch):
    """The last words of a program that fails are the note, without marks of a table."""
    row = row_of_program(runner, peers, options, tmp_path, monkeypatch, "fails")
    assert row.note == "it cannot run: ImportError: no module named / snow"


def test_unknown_peer_is_refused(runner, capsys):
    """The command names those that there are."""
    with pytest.raises(SystemExit) as ended:
        runner.parsed(["taichy"])
    assert ended.value.code == 2
    assert "no peer is called taichy; there are taichi, " in capsys.readouterr().err


def test_case_survives_its_file(tmp_path):
    """Arrays and numbers come back as they were."""
    with script("benchmarks/peers", "work") as work, script("benchmarks/peers", "case") as case:
        one = work.case_of((3, 3, 3))
        one.save(tmp_path / "case.npz")
        again = case.Case.load(tmp_path / "case.npz")
    assert (again.x == one.x).all()
    assert (again.shape, again.cells, again.E0, again.dt) == (one.shape, one.cells, one.E0, one.dt)
    order = one.by_rows()
    assert sorted(order) == list(range(len(one.x)))
