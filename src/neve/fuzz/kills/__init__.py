"""Runs that are killed and hurt, and what must come of them."""
