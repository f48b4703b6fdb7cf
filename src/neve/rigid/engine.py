"""Load the rigid-body engine, MuJoCo, at its first use."""

from __future__ import annotations

import contextlib
import logging
import re
import warnings
from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neve.scene.checks.joined import kind_of
from neve.scene.errors import SceneWarning


@lru_cache
def engine() -> Any:
    """Return the module `mujoco`, its warnings turned to the log of Neve.

    By default MuJoCo prints them and writes a file MUJOCO_LOG.TXT where the program runs. A handler that the
    program itself has installed is kept.
    """
    import mujoco

    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_tell)
    return mujoco


UNTOLD = (" in QACC ", "Attach conflict", " is deprecated")
"""Of accelerations beyond 1e10, which light bodies in snow have; of memory and cameras of a robot's file that
differ from those of the scene; of words that later engines will not know, and that still act."""
_told: Counter[str] = Counter()
"""How often each kind of warning has come since the last model was made."""


def forget() -> None:
    """Let the engine's warnings be told anew: a new model is made."""
    _told.clear()


def _tell(text: str) -> None:
    """Log a warning of the engine, unless it is UNTOLD.

    Of a kind that comes again in every step, those are told whose number is 1, 10, 100 and so on. Positions
    and velocities are checked after each step (`neve.rigid.bodies`).
    """
    if any(words in text for words in UNTOLD):
        return
    said = text.strip().splitlines()[0]
    kind = kind_of(said)
    _told[kind] += 1
    count = _told[kind]
    if set(str(count)[1:]) <= {"0"} and str(count)[0] == "1":
        times = f" (for the {count:,}th time)" if count > 1 else ""
        logging.getLogger("neve").warning("rigid bodies: %s%s", said.rstrip("."), times)


@contextlib.contextmanager
def heard() -> Iterator[None]:
    """Turn the warnings of the engine's compiler, which are Python's, to SceneWarnings, unless UNTOLD."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        yield
    for said in dict.fromkeys(str(warning.message) for warning in found):
        if said.strip() and not any(words in said for words in UNTOLD):
            warnings.warn(
                f"rigid bodies: {said.strip().splitlines()[0].rstrip('.')}", SceneWarning, stacklevel=3
            )


def quaternion(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quaternion (w, x, y, z) of a rotation `matrix` (3, 3)."""
    found = np.zeros(4)
    engine().mju_mat2Quat(found, np.ascontiguousarray(matrix).reshape(9))
    return found


def reason(error: Exception) -> str:
    """Return the engine's message as the end of one sentence."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    text = re.sub(r"^(XML )?Error: ", "", lines[0] if lines else type(error).__name__).rstrip(".!")
    text = text.replace("mjMINVAL", "1e-15")
    where = next((match for line in lines[1:] if (match := re.search(r"line \d+", line, re.I))), None)
    where = where or re.search(r"Line number=(\d+)", " ".join(lines[1:]))
    element = re.search(r"Element name '([^']+)'", str(error))
    line = f"line {re.sub(r'[^0-9]', '', where[0])}" if where else ""
    named = f'"{element[1]}"' if element and element[1] not in text else ""
    place = f" ({', '.join(filter(None, (named, line)))})" if named or line else ""
    begin = text[:1] if text[1:2].isupper() else text[:1].lower()  # XML stays XML
    return f"{begin}{text[1:]}{place}"
