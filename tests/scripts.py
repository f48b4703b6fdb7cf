"""Scripts of the repository, which are no part of the package, as modules."""

import contextlib
import importlib
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


@contextlib.contextmanager
def script(folder, name):
    """The script `name` of a folder of the repository, imported from there."""
    path = str(ROOT / folder)
    sys.path.insert(0, path)
    try:
        yield importlib.import_module(name)
    finally:
        sys.path.remove(path)
