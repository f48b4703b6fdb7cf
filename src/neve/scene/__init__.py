"""Describe scenes: what they may hold, how they are read, and what is doubtful about them."""
