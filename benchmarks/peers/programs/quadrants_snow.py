"""The program for Taichi in its fork Quadrants, the language of Genesis."""

import os

os.environ["SNOW_LANGUAGE"] = "quadrants"
from taichi_snow import Program

__all__ = ["Program"]
