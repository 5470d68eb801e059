"""The errors a user can cause or meet; the CLI turns each into one line and exit code 2."""


class TopomapError(Exception):
    """Base of every expected error; its text is one line that says what would be right."""


class ConfigError(TopomapError):
    """A configuration file, key or value is wrong."""


class DataError(TopomapError):
    """A file that was read (log, map, data set) is missing, damaged or of another form."""


class ShapeError(TopomapError, ValueError):
    """An array has another shape, type or range than its docstring says."""
