"""The version that stands in run folders, checkpoints and citations."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """Return the version of the installed package; "0+source" in a source tree that is not installed."""
    try:
        return metadata.version("neve")
    except metadata.PackageNotFoundError:
        return "0+source"
