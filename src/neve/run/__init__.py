"""Run a simulation into a run folder: the loop, and the outputs that it writes."""

from neve.run.loop import last_frame, run, run_scene
from neve.run.outputs.context import FrameContext, Output, RunContext

__all__ = ["FrameContext", "Output", "RunContext", "last_frame", "run", "run_scene"]
