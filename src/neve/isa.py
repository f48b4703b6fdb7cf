"""The build of the core for this processor.

`pip install .` compiles one build, for the machine at hand. A package to share carries several, one folder of
compiled modules for each instruction set (`builds/x86-64-v3`, ...). The best one that the processor runs is
put on the path of `neve` when it is imported. The variable NEVE_ISA names another.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, MutableSequence
from pathlib import Path

VARIABLE = "NEVE_ISA"
MAX_THREADS = 4 * (os.cpu_count() or 1)
"""Threads that may be asked for: four for each processor."""


class IsaError(ImportError):
    """One sentence for the user: why no build of the core can be taken."""


def processor() -> list[str]:
    """Return the x86-64 levels of this processor, lowest first; nothing on others."""
    from neve import _cpu

    return _cpu.levels()


def carried(path: Iterable[str]) -> dict[str, Path]:
    """Return the folder of each build in a package with this path; none if it has one build alone."""
    folders = [folder for entry in path for folder in Path(entry).glob("builds/*") if folder.is_dir()]
    return {folder.name: folder for folder in sorted(folders)}


def choose(carried: Collection[str], levels: list[str], asked: str | None) -> str | None:
    """Return the instruction set to take; None where there is one build alone.

    carried: of the package. levels: of the processor, lowest first. asked: what NEVE_ISA says, if anything.
    Errors: IsaError if what is asked for is not carried or no build runs on this processor.
    """
    if not carried:
        if asked:
            raise IsaError(
                f"{VARIABLE} = {asked}: this copy of Neve has one build, for the machine it was compiled on; "
                f"unset {VARIABLE}."
            )
        return None
    if asked and asked not in carried:
        raise IsaError(f"{VARIABLE} = {asked}: this copy of Neve carries {', '.join(carried)}.")
    runs = [level for level in levels if level in carried]
    if asked and asked not in runs:
        others = ", ".join(runs) or "none"
        raise IsaError(
            f"{VARIABLE} = {asked}: this processor cannot run it; of those carried it runs {others}."
        )
    if not runs:
        raise IsaError(
            f"this copy of Neve carries {', '.join(carried)}, and this processor runs none of them: "
            "compile it here, by `pip install .` in its sources."
        )
    return asked or runs[-1]


def extend(path: MutableSequence[str]) -> IsaError | None:
    """Put the folder of the build to take on the path of the package; return why there is none."""
    builds = carried(path)
    try:
        isa = choose(builds, processor() if builds else [], os.environ.get(VARIABLE))
    except IsaError as error:
        return error
    if isa:
        path.append(str(builds[isa]))
    return None


def advice(isa: str, carried: Collection[str], levels: list[str]) -> str | None:
    """Return how to make Neve faster on this processor, or None where it already uses what there is.

    isa: of the build in use. carried: of the package. levels: of the processor, lowest first.
    """
    if not levels or isa == levels[-1]:
        return None
    if levels[-1] in carried:
        return f"this processor has {levels[-1]}, the build in use is for {isa}: unset {VARIABLE}"
    return f"this processor has {levels[-1]}, the build uses {isa}: `pip install .` in the sources is faster"
