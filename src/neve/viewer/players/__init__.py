"""Players: the thread that has a run, live or recorded, and its latest snapshot."""
