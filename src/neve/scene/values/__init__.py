"""Kinds of values of a scene: their limits and units, their words, and what there is to choose from."""
