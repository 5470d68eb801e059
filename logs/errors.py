"""The one error of logs."""


class LogError(Exception):
    """A log can't be written or read; its text is one line that names the file and what is wrong."""
