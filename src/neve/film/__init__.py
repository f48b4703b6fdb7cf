"""Path-traced pictures and films of finished runs."""
