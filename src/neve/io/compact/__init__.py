"""Compact frames: the numbers of a frame in less than half the bytes, with errors that are known."""
