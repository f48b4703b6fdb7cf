"""Many runs of one scene: which values, on which processes, and one table of what came out."""

from neve.sweep.design import Vary, grid, latin, read_vary, together
from neve.sweep.run import Sweep, sweep

__all__ = ["Sweep", "Vary", "grid", "latin", "read_vary", "sweep", "together"]
