"""Scripts of the repository, which are no part of the package, as modules."""

import contextlib
import importlib
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


@contextlib.contextmanager
def script(folder, name):
    """The script `name` of a folder of the repository, imported from there, whatever else has its name."""
    path = str(ROOT / folder)
    sys.path.insert(0, path)
    others = {}
    known = sys.modules.get(name)
    if known is not None and Path(known.__file__ or ".").parent != ROOT / folder:
        others = {each: sys.modules.pop(each) for each in [*sys.modules] if each.split(".")[0] == name}
    try:
        yield importlib.import_module(name)
    finally:
        sys.path.remove(path)
        sys.modules.update(others)
