"""Load the rigid-body engine, MuJoCo, at its first use."""

from __future__ import annotations

import logging
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray


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


def _tell(text: str) -> None:
    logging.getLogger("neve").warning("rigid bodies: %s", text.strip().splitlines()[0])


def quaternion(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quaternion (w, x, y, z) of a rotation `matrix` (3, 3)."""
    found = np.zeros(4)
    engine().mju_mat2Quat(found, np.ascontiguousarray(matrix).reshape(9))
    return found
