"""Say in one sentence what is wrong, or doubtful, with a scene."""


class SceneError(ValueError):
    """Report a scene that cannot be used, in one sentence: file, key, value, and what is allowed."""

    def __init__(self, sentence: str) -> None:
        """Take the sentence, with or without its full stop."""
        one_line = sentence.rstrip(".").replace("\n", "\\n")
        super().__init__(f"{one_line}.")


class SceneWarning(UserWarning):
    """Warn, in one sentence with a better value, of a scene that runs but may not show what is meant."""
