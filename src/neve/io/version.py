"""The version that stands in run folders, checkpoints and citations."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """Return the version of the installed package; "0+source" in a source tree that is not installed."""
    try:
        return metadata.version("neve")
    except metadata.PackageNotFoundError:
        return "0+source"


def build() -> str:
    """Return the version with what decides the last bits: how the core was compiled, and NumPy's version.

    Such as "0.1.0 (x86-64-v4, gcc 12.2.0, numpy 2.4.6)".
    """
    from neve import _core

    info = _core.build_info()
    return f"{version()} ({info['isa']}, {info['compiler']}, numpy {metadata.version('numpy')})"
