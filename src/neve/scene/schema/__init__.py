"""Say what a scene may hold: every key with its default, unit, range and source."""
