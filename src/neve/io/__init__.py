"""Read and write the files of a run: every write is atomic, every failure is one sentence."""
