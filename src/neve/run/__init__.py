"""Run a simulation into a run folder: the loop, and the outputs that hang on it."""

from neve.run.loop import last_frame, run, run_scene
from neve.run.outputs import FrameContext, Output

__all__ = ["FrameContext", "Output", "last_frame", "run", "run_scene"]
