"""Run the same snow in Neve and in its peers, each in an environment of its own, and write one table.

    python benchmarks/peers/run.py                       # all peers, 1,000,000 particles
    python benchmarks/peers/run.py newton --particles 20k --batches 3 --csv peers.csv

A peer and Neve take turns: a batch of one, a batch of the other, while the one that waits does nothing. Both
are given the same number of threads and the same particles. Set-up, compilation and the first batch do not
count. A peer with the same step must end like Neve within one percent, or it gets no numbers. A peer that
cannot be installed or run has a row with the reason.
"""

from __future__ import annotations

import argparse
import contextlib
import datetime
import json
import os
import platform
import shlex
import statistics
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import sleep
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
from peers import HERE, PEERS, CannotRunError, Peer, last_sentence
from table import About, Row, as_csv, as_markdown

PAUSE = 0.2
"""Before each batch [s], in which the other's threads fall asleep."""
ALIKE = 0.01
"""By how much outcomes of the same step may differ [1]."""


@dataclass
class Worker:
    """Hold a program that answers (see `worker.py`)."""

    process: Any
    errors: Path
    told: dict[str, Any]

    def ask(self, line: str) -> dict[str, Any]:
        """Return the answer to a line. Errors: CannotRunError if there is none."""
        try:
            print(line, file=self.process.stdin, flush=True)
        except OSError:
            raise CannotRunError(self.last_words()) from None
        return self.answer()

    def answer(self) -> dict[str, Any]:
        """Return the next answer. Errors: CannotRunError if there is none."""
        line = self.process.stdout.readline()
        if not line:
            raise CannotRunError(self.last_words())
        return dict(json.loads(line))

    def last_words(self) -> str:
        """Return why the program has ended."""
        self.process.wait()
        if self.process.returncode == -9:
            return "it was ended: it took too long, or too much memory"
        return "it cannot run: " + last_sentence(self.errors.read_text(encoding="utf-8", errors="replace"))


@contextlib.contextmanager
def working(python: Path, program: str, case: Path, options: argparse.Namespace) -> Iterator[Worker]:
    """Start a program and end it. Errors: CannotRunError if it does not begin."""
    errors = case.with_name(f"{program}.log")
    command = [python, HERE / "worker.py", program, case, options.threads, options.device]
    with errors.open("w", encoding="utf-8") as log:
        process = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
    clock = threading.Timer(options.limit, process.kill)
    clock.start()
    try:
        worker = Worker(process, errors, {})
        worker.told = worker.answer()
        yield worker
    finally:
        clock.cancel()
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()


def measured(peer: Peer, case: Path, options: argparse.Namespace) -> Row:
    """Return the row of a peer. Errors: CannotRunError."""
    load = os.getloadavg()[0]
    python = peer.python(options.folder, options.limit)
    with (
        working(Path(sys.executable), "neve_snow", case, options) as neve,
        working(python, peer.program, case, options) as other,
    ):
        neve_seconds = options.steps * neve.told["dt"]
        seconds = max(neve_seconds, other.told["dt"])
        pairs = []
        for _ in range(options.batches + 1):
            sleep(PAUSE)
            ours = neve.ask(repr(neve_seconds))
            sleep(PAUSE)
            theirs = other.ask(repr(seconds))
            pairs.append((ours, theirs))
        if peer.same_step:
            require_alike(neve.ask(""), other.ask(""))
        return row_of(peer, pairs[1:], other.told, load, options)


def row_of(
    peer: Peer,
    pairs: Sequence[tuple[dict[str, float], dict[str, float]]],
    told: dict[str, Any],
    load: float,
    options: argparse.Namespace,
) -> Row:
    """Return the row of a peer from pairs of batches, Neve's and its own."""
    walls = [theirs["wall"] / theirs["seconds"] for _, theirs in pairs]
    neve_walls = [ours["wall"] / ours["seconds"] for ours, _ in pairs]
    ratios = [b / a for a, b in zip(neve_walls, walls, strict=True)]
    rates = [told["particles"] * theirs["steps"] / theirs["wall"] / 1e6 for _, theirs in pairs]
    return Row(
        peer=peer.name,
        version=told["version"],
        law=told["law"],
        precision=told["precision"],
        particles=told["particles"],
        dx=options.dx,
        dt=told["dt"],
        threads=options.threads,
        device=options.device,
        rate=statistics.median(rates),
        wall=statistics.median(walls),
        neve_wall=statistics.median(neve_walls),
        ratio=statistics.median(ratios),
        least=min(ratios),
        largest=max(ratios),
        load=load,
        note=peer.note,
    )


def require_alike(ours: dict[str, float], theirs: dict[str, float]) -> None:
    """Compare the outcomes of the same step. Errors: CannotRunError if they differ."""
    for name, value in ours.items():
        scale = 1.0 if name == "flowed" else abs(value)
        if not abs(value - theirs[name]) <= ALIKE * scale:
            raise CannotRunError(
                f"it does not do the same work: {name} is {theirs[name]:.6g}, and {value:.6g} in Neve"
            )


def rows_of(peers: Sequence[Peer], case: Path, options: argparse.Namespace) -> Iterator[Row]:
    """Yield the row of each peer; of one that cannot run, why."""
    for peer in peers:
        print(f"{peer.name} ...", file=sys.stderr, flush=True)
        try:
            yield measured(peer, case, options)
        except CannotRunError as reason:
            yield Row(peer.name, note=str(reason))


def parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the options of the command line."""
    names = [peer.name for peer in PEERS]
    parser = argparse.ArgumentParser(description="Neve and its peers on the same snow, in one table.")
    parser.add_argument("peers", nargs="*", metavar="PEER", help=", ".join(names))
    parser.add_argument("--particles", choices=("20k", "200k", "1m"), default="1m")
    parser.add_argument("--device", choices=("cpu", "cuda"), default="cpu")
    parser.add_argument("--threads", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--batches", type=int, default=7)
    parser.add_argument("--steps", type=int, default=20, help="of Neve in a batch")
    parser.add_argument("--limit", type=float, default=1800.0, help="seconds for a peer to run")
    parser.add_argument("--folder", type=Path, help="where the environments lie")
    parser.add_argument("--csv", type=Path, help="file for the table")
    parser.add_argument("--markdown", type=Path, help="file for the table")
    options = parser.parse_args(arguments)
    if unknown := set(options.peers) - set(names):
        parser.error(f"no peer is called {sorted(unknown)[0]}; there are {', '.join(names)}")
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    options.folder = (options.folder or cache / "neve" / "peers").resolve()
    return options


def main() -> None:
    """Measure, and write the table."""
    from work import case_of

    import neve
    from neve.bench.run import BLOCKS, cpu

    options = parsed()
    case = case_of(BLOCKS[options.particles].cells)
    options.dx = case.dx
    about = About(
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        hardware=f"{cpu()}, {os.cpu_count()} cores",
        neve=neve.__version__,
        python=platform.python_version(),
        command=shlex.join(["python", "benchmarks/peers/run.py", *sys.argv[1:]]),
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.npz"
        case.save(path)
        chosen = [peer for peer in PEERS if not options.peers or peer.name in options.peers]
        rows = list(rows_of(chosen, path, options))
    print(as_markdown(about, rows))
    for file, text in ((options.csv, as_csv), (options.markdown, as_markdown)):
        if file:
            file.write_text(text(about, rows), encoding="utf-8")


if __name__ == "__main__":
    main()
