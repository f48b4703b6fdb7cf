"""The same bits on other processors, as far as one machine can play another.

OpenBLAS and NumPy look at the processor and take one of several codes, which add in different orders, and
fuse or do not. A variable of each makes them take that of an older one.
"""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[3]
DISPATCHED = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
OLDER = {"OPENBLAS_CORETYPE": "Nehalem", "NPY_DISABLE_CPU_FEATURES": ",".join(DISPATCHED)}
SEEN = """
import hashlib, numpy as np
rng = np.random.default_rng(0)
print(hashlib.md5(np.array([np.dot(a, a) for a in rng.random((500, 40))]).tobytes()).hexdigest())
print(hashlib.md5(np.exp(rng.random(9999)).tobytes()).hexdigest())
"""
pytestmark = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="these variables are for x86-64"
)


def run(older, *command):
    """What a command of the interpreter prints, on this processor or as on an older one."""
    environment = {name: value for name, value in os.environ.items() if name not in OLDER}
    environment |= {"OMP_NUM_THREADS": "1"} | (OLDER if older else {})
    command = [sys.executable, *command]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def test_bits_do_not_depend_on_the_code_of_libraries(tmp_path):
    """Every preset and the other small runs of tools/golden.py, with bodies and a robot: the same bits.

    Libraries sample, and move bodies in each step; a tenth of the time has some steps of every scene.
    """
    found = []
    for older in (False, True):
        path = tmp_path / f"{older}.json"
        run(older, str(ROOT / "tools/golden.py"), "record", str(path), "--share", "0.1")
        found.append(json.loads(path.read_text(encoding="utf-8")))
    assert found[0] == found[1]


@pytest.mark.skipif(len(DISPATCHED) < 2, reason="NumPy has no choice on this processor")
def test_libraries_take_other_code():
    """The variables do what the test above needs: dot products and exponentials of the libraries change."""
    here, older = (run(older, "-c", SEEN).split() for older in (False, True))
    assert any(a != b for a, b in zip(here, older, strict=True))
