"""Files of robots, MJCF and URDF: what they name, whether they can be read, and reading them."""
