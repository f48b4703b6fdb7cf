"""Snow under compression: in a ring, on its yield surface, against measurements of real snow."""
