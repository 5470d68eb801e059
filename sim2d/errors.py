"""The errors of the simulator that a user can cause."""


class WorldError(ValueError):
    """A world's name or data is wrong; the text is one line that says what would be right."""
