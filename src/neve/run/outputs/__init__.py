"""What a run writes besides the scene: one file for each kind of output, listed in `registry.py`."""
