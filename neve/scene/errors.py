"""Say in one sentence what is wrong with a scene."""


class SceneError(ValueError):
    """Report a scene that cannot be used, in one sentence: file, key, value, and what is allowed."""

    def __init__(self, sentence: str) -> None:
        """Take the sentence, with or without its full stop."""
        one_line = sentence.rstrip(".").replace("\n", "\\n")
        super().__init__(f"{one_line}.")
