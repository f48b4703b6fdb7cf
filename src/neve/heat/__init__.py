"""Heat of snow by any method."""
