"""What a robot file may take to be read: processor time and memory, which POSIX systems enforce."""

from __future__ import annotations

import sys

SECONDS = 20
"""Processor time for one file [s]."""
PATIENCE = 60.0
"""Time by the clock for one file [s], also where the system enforces no limit."""
BYTES = 4 << 30
"""Address space of the process that reads [bytes]."""


def limit_memory() -> None:
    """Let this process have BYTES of address space, and write no core file."""
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _lower(resource.RLIMIT_AS, BYTES)


def limit_seconds(seconds: int) -> None:
    """Let this process have `seconds` of processor time from now on."""
    if sys.platform == "win32":
        return
    import resource

    used = resource.getrusage(resource.RUSAGE_SELF)
    _lower(resource.RLIMIT_CPU, int(used.ru_utime + used.ru_stime) + 1 + seconds)


def _lower(kind: int, most: int) -> None:
    import resource

    _, hard = resource.getrlimit(kind)
    if hard != resource.RLIM_INFINITY:
        most = min(most, hard)
    try:
        resource.setrlimit(kind, (most, hard))
    except (ValueError, OSError):  # macOS refuses a limit below what is in use
        return
