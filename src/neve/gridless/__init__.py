"""What methods without a grid have in common."""
