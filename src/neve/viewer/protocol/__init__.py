"""What the page and the server say to each other: commands, messages and the bytes of a state."""
