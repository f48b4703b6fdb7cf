"""Measure how fast the step runs on this machine."""
