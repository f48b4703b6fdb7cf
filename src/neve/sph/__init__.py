"""Snow as smoothed particles: implicit compressible SPH after Gissler et al. 2020."""
