"""Neve: a snow laboratory."""
