"""Attacks on Neve, each from a seed, and what must hold: the command `neve fuzz`."""
