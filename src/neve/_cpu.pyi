"""What the processor can do."""

def levels() -> list[str]:
    """Return the x86-64 levels of this processor, lowest first; an empty list on other processors."""
