"""Input files that a seeded mutator has damaged: each is read, or refused in one sentence."""
