"""Bodies and robots that the snow moves, by the rigid-body engine MuJoCo."""
