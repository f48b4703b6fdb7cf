"""The error that tells a user what is wrong with a run's files."""

from __future__ import annotations

import errno
from pathlib import Path

_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file grew past the size that this system allows",
    errno.EROFS: "the disk is read-only",
    errno.EACCES: "permission is denied",
    errno.EPERM: "permission is denied",
    errno.ENOTDIR: "a part of this path is a file, not a folder",
    errno.EISDIR: "a folder stands where the file belongs",
    errno.ENAMETOOLONG: "the name is too long",
}


class RunError(RuntimeError):
    """One sentence for the user: what could not be done with a run, why, and what to do about it."""


def reason(error: OSError) -> str:
    """Say in a few plain words why the system refused to read or write a file."""
    if error.errno in _REASONS:
        return _REASONS[error.errno]
    return (error.strerror or str(error) or type(error).__name__).lower()


def cannot_write(path: Path, error: OSError) -> RunError:
    """Turn a failed write of `path` into the error that the user sees."""
    advice = ""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        advice = "; free some space and continue with --resume"
    return RunError(f"{path} could not be written: {reason(error)}{advice}.")


def cannot_read(path: Path, error: OSError) -> RunError:
    """Turn a failed read of `path` into the error that the user sees."""
    missing = isinstance(error, FileNotFoundError)
    return RunError(f"{path} could not be read: {'it does not exist' if missing else reason(error)}.")
