"""Elastic bodies: a bar, its refinement, two discs, a column under its own weight."""
