"""A run goes on without its standard streams, and Ctrl-C is 130 from the first moment on."""

import errno
import io
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import fake_neve
import pytest
from patience import PATIENCE

from neve.run.progress import Lines, Warnings, follow
from neve.system import stopping
from neve.system.streams import Steady

FAKE = Path(fake_neve.__file__)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="streams of a shell")


class Refusing(io.StringIO):
    """A stream of a full disk, of a reader that has gone, or one that was closed."""

    def __init__(self, error):
        super().__init__()
        self.error = error

    def write(self, text):
        raise self.error

    flush = isatty = lambda self: self.write("")


@pytest.mark.parametrize(
    "error", [OSError(errno.ENOSPC, "full"), BrokenPipeError(errno.EPIPE, "gone"), ValueError("closed file")]
)
def test_progress_drops_what_is_not_taken(error):
    """Neither lines nor warnings raise, whatever the stream does; nor if there is none."""
    for stream in (Refusing(error), None):
        for progress in (Lines("ball", 0, 2, Steady(stream)), Warnings(Steady(stream))):
            with progress:
                progress.update(1, 10, 3)
                progress.say("a sentence")
    with follow("ball", 0, 2, stream=Refusing(error)) as progress:
        progress.update(1, 10, 3)


@pytest.mark.parametrize(
    "streams",
    ["2>&-", "2>/dev/full", "<&- >&- 2>&-", ">/dev/full 2>/dev/full", "2> >(head -c 1)"],
)
def test_a_run_finishes_without_its_streams(scene_file, tmp_path, streams):
    """Streams that are closed, full, or read no longer: the run is whole and ends with 0."""
    if not os.path.exists("/dev/full"):
        pytest.skip("needs a device that is always full")
    out = tmp_path / "out"
    line = f'exec "{sys.executable}" "{FAKE}" run "{scene_file}" --out "{out}" {streams}'
    assert subprocess.run(["bash", "-c", line], check=False, timeout=PATIENCE).returncode == 0
    assert (out / "preview.png").exists()
    assert len((out / "log.csv").read_text().splitlines()) == 10  # a head, frames 0 to 8
    assert b"frame" not in b"".join(p.read_bytes() for p in out.glob("*.png"))  # no message got into a file


@pytest.mark.parametrize(
    ("line", "code", "words"),
    [
        ("list >/dev/full", 2, "neve: standard output could not be written: the disk is full.\n"),
        ("info --json >/dev/full", 2, "neve: standard output could not be written: the disk is full.\n"),
        ("list >&-", 0, ""),
        ("list | true; exit ${PIPESTATUS[0]}", 141, ""),
        ("run nothing 2>/dev/full", 2, ""),
        ("run nothing 2>&-", 2, ""),
    ],
)
def test_output_that_is_not_taken(line, code, words):
    """A full disk is one sentence, a reader that has gone needs none; the exit code tells both."""
    if not os.path.exists("/dev/full"):
        pytest.skip("needs a device that is always full")
    slow = "sleep 0.5; " if "|" in line else ""  # the reader is gone by then
    script = f'neve() {{ {slow}"{sys.executable}" -m neve.cli "$@"; }}; neve {line}'
    done = subprocess.run(
        ["bash", "-c", script], check=False, capture_output=True, text=True, timeout=PATIENCE
    )
    assert (done.returncode, done.stderr) == (code, words)


def test_ctrl_c_while_a_module_is_imported(tmp_path):
    """Before the command line is ready an import ends with 130; then the exception waits for its end."""
    (tmp_path / "slow.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(0.05)\nprint('whole')\n"
    )
    script = (
        "import sys; sys.argv[0] = 'neve'; import neve, contextlib; from neve.system import stopping\n"
        "with stopping.Ready() if {ready} else contextlib.nullcontext():\n"
        "    try:\n"
        "        import slow, time; time.sleep(5)\n"
        "    except KeyboardInterrupt: print('stopped', slow.__name__)"
    )
    told = {}
    for ready in (True, False):
        command = [sys.executable, "-c", script.format(ready=ready)]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
        told[ready] = done.returncode, done.stdout, done.stderr
    assert told == {True: (0, "whole\nstopped slow\n", ""), False: (130, "", "neve: stopped\n")}


def test_a_library_does_not_touch_the_signals():
    """Only the command line hears Ctrl-C itself."""
    script = "import signal, neve; print(signal.getsignal(signal.SIGINT) is signal.default_int_handler)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "True\n"
    assert not stopping.is_command_line()


@pytest.mark.parametrize(("number", "expected"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_at_any_moment(scene_file, tmp_path, number, expected):
    """From the moment when Python has started, Ctrl-C and SIGTERM end with their codes and no traceback."""
    script = (
        "import sys; sys.argv[0] = 'neve'; import neve; print('up', flush=True)\n"
        f"import neve.cli; sys.path.insert(0, {str(FAKE.parent)!r})\n"
        "import fake_neve; fake_neve.install(); neve.cli.main()"
    )
    for turn in range(4):
        line = [sys.executable, "-c", script, "run", str(scene_file), "--out", str(tmp_path / str(turn))]
        env = os.environ | {"NEVE_FAKE_PAUSE": "10"}
        process = subprocess.Popen(
            line,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=env,
            start_new_session=True,
        )
        assert process.stdout.readline() == "up\n"
        time.sleep(random.uniform(0.0, 0.4))
        process.send_signal(number)
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)  # the first one finishes the frame
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == expected, err
        assert "Traceback" not in err


@pytest.mark.parametrize(("number", "codes"), [(signal.SIGINT, {0, 130}), (signal.SIGTERM, {143})])
def test_a_server_ends_at_any_moment(scene_file, number, codes):
    """While `neve view` reads, opens its socket or serves: no traceback; Ctrl-C is the usual end."""
    line = [sys.executable, "-c", "import sys; sys.argv[0] = 'neve'; import neve; print('up', flush=True)"]
    line[-1] += "; import neve.cli; neve.cli.main()"
    for wait in (random.uniform(0.1, 1.0), None):
        process = subprocess.Popen(
            [*line, "view", str(scene_file), "--set", "numerics.dx=0.2", "--port", "0"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stdout.readline() == "up\n"
        if wait is None:
            assert process.stdout.readline().endswith("Ctrl-C ends.\n")
        else:
            time.sleep(wait)
        process.send_signal(number)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode in codes - ({130} if wait is None else set()), err
        assert "Traceback" not in err
        assert "Warning" not in err
