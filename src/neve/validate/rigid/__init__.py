"""Rigid bodies on snow: a ball that falls, a wheel that drives."""
