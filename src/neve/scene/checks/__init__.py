"""Look for what a scene may hold but is unlikely to be meant."""
