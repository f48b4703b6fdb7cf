"""Columns of snow that are pushed through the sections of emitters."""
