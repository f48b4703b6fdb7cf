"""Where falling snow comes to lie, what of it slides, and the shape of what stays."""
