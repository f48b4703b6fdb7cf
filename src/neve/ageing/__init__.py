"""What days make of snow that lies: it settles, warms, melts, freezes again and grows stronger."""
