"""The peers: how each is installed, and in what its step differs from Neve's."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent


class CannotRunError(Exception):
    """Raised with one sentence that says why a peer is left out."""


@dataclass(frozen=True)
class Peer:
    """Name a peer.

    Attributes:
        name: its name in the table and of its folder
        program: module of `programs/` that runs the snow
        packages: what pip installs into its environment
        same_step: whether it is the same explicit step: then the outcomes are compared
        note: what differs
        prepare: a script of `programs/` that builds it, and its arguments
    """

    name: str
    program: str
    packages: tuple[str, ...] = ()
    same_step: bool = False
    note: str = ""
    prepare: tuple[str, ...] = ()

    def python(self, folder: Path, seconds: float) -> Path:
        """Return the interpreter of the peer's environment in `folder`, made and filled if it is not there.

        Errors: CannotRunError for what cannot be installed, or not within `seconds`.
        """
        home = folder / self.name
        python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
        ready = home / "ready.txt"
        wanted = "\n".join((*self.packages, *self.prepare))
        if ready.exists() and ready.read_text(encoding="utf-8") == wanted:
            return python
        shutil.rmtree(home, ignore_errors=True)
        _run([sys.executable, "-m", "venv", home], seconds, "no environment can be made")
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        _run([*pip, "numpy", *self.packages], seconds, "cannot be installed")
        if self.prepare:
            script, *rest = self.prepare
            _run([python, HERE / "programs" / script, home, *rest], seconds, "cannot be built")
        ready.write_text(wanted, encoding="utf-8")
        return python


def _run(command: Sequence[str | Path], seconds: float, failure: str) -> None:
    """Run a command quietly. Errors: CannotRunError, `failure` and why."""
    try:
        subprocess.run(
            [str(part) for part in command],
            check=True,
            capture_output=True,
            text=True,
            timeout=seconds,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        raise CannotRunError(f"{failure} within {seconds:.0f} s") from None
    except subprocess.CalledProcessError as error:
        raise CannotRunError(f"{failure}: {last_sentence(error.stderr)}") from None
    except OSError as error:
        raise CannotRunError(f"{failure}: {error.strerror}") from None


def last_sentence(text: str | None) -> str:
    """Return what a program said last, in one line without the marks of a table."""
    lines = [line.strip() for line in (text or "").splitlines() if line.strip()]
    said = [line for line in lines if line.startswith(("ERROR", "error")) or "Error" in line] or lines
    return " ".join(said[-1].replace("|", "/").split())[:200] if said else "it said nothing"


PEERS = (
    Peer("taichi", "taichi_snow", ("taichi==1.7.4",), same_step=True, note="own program, dense grid"),
    Peer("quadrants", "quadrants_snow", ("quadrants",), same_step=True, note="the program for Taichi"),
    Peer("warp", "warp_snow", ("warp-lang",), same_step=True, note="own kernels; one thread on a processor"),
    Peer("genesis", "genesis_snow", ("torch", "genesis-world"), note="its snow: the same law, own contact"),
    Peer("newton", "newton_snow", ("newton",), note="implicit, own law; one thread on a processor"),
    Peer("nexus", "nexus_snow", ("dimforge-nexus3d",), note="needs WebGPU"),
    Peer("matter", "matter_snow", prepare=("matter_build.py",), note="Cam-Clay, own dt"),
)
