"""How much memory is free: of the machine, of the container that the process is in, of its own limits."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

RESERVE = 0.95
"""Share of the free memory that may be asked for: the system needs some for itself."""
UNLIMITED = 1 << 60
"""Limits of a container from here on are none [bytes]."""


def free() -> int | None:
    """Return how many bytes this process can still get; None if the system does not say.

    The least of what the machine has available, what the control groups of the process leave (Linux cgroups,
    versions 1 and 2; files that are only cached count as free), and what is left of its address space.
    """
    found = [size for size in (*_machine(), *_groups(Path("/proc/self/cgroup")), *_own_limit())]
    return max(0, min(found)) if found else None


def lacking(needed: float) -> str | None:
    """Say what is needed and what is free if `needed` bytes are more than that; None if there is enough."""
    left = free()
    if left is None or needed <= RESERVE * left:
        return None
    return f"needs about {in_words(needed)} of memory, and {in_words(left)} are free"


def in_words(size: float) -> str:
    """Return a number of bytes in GB or MB."""
    return f"{size / 1e9:.3g} GB" if size >= 1e9 else f"{size / 1e6:.3g} MB"


def _machine() -> Iterator[int]:
    """Yield what the machine has available."""
    with contextlib.suppress(OSError, ValueError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                yield 1024 * int(line.split()[1])
                return
    if sys.platform == "win32":
        yield from _windows()
        return
    with contextlib.suppress(OSError, ValueError, AttributeError):  # macOS does not know the first name
        yield os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _windows() -> Iterator[int]:
    """Yield the free memory that GlobalMemoryStatusEx tells (Microsoft's documentation of sysinfoapi.h)."""
    import ctypes

    numbers = (ctypes.c_uint64 * 8)()  # length and load, 4 bytes each, then seven sizes
    ctypes.cast(numbers, ctypes.POINTER(ctypes.c_uint32))[0] = ctypes.sizeof(numbers)
    if ctypes.windll.kernel32.GlobalMemoryStatusEx(numbers):  # type: ignore[attr-defined, unused-ignore]
        yield int(numbers[2])


def _groups(told: Path, root: Path = Path("/sys/fs/cgroup")) -> Iterator[int]:
    """Yield what each control group of the process, and each that it lies in, leaves of its limit."""
    try:
        lines = told.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return
    for line in lines:
        _, controllers, path = line.split(":", 2)
        if controllers == "":
            yield from _chain(root, path, ("memory.max", "memory.current", "inactive_file"))
        elif "memory" in controllers.split(","):
            names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
            yield from _chain(root / "memory", path, names)


def _chain(root: Path, path: str, names: tuple[str, str, str]) -> Iterator[int]:
    """Yield limit - use of the group at `path` below `root` and of those above it, as far as they are there.

    In a container `path` may be that of the host, while `root` is the container's own group.
    """
    limit, use, cached = names
    group = root / path.lstrip("/")
    for place in (group, *group.parents):
        if place != root and root not in place.parents:
            return
        with contextlib.suppress(OSError, ValueError):
            most = int((place / limit).read_text(encoding="ascii"))  # "max" is no number: no limit
            if most < UNLIMITED:
                yield most - int((place / use).read_text(encoding="ascii")) + _cached(place, cached)


def _cached(place: Path, name: str) -> int:
    """Return the bytes of files in memory that the group can do without."""
    with contextlib.suppress(OSError, ValueError):
        for line in (place / "memory.stat").read_text(encoding="ascii").splitlines():
            key, _, number = line.partition(" ")
            if key == name:
                return int(number)
    return 0


def _own_limit() -> Iterator[int]:
    """Yield what is left of the address space that the process may have."""
    if sys.platform == "win32":
        return
    import resource

    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return
    with contextlib.suppress(OSError, ValueError):
        used = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        yield most - used * resource.getpagesize()
