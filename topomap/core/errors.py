"""The errors a user can cause or meet; the CLI turns each into one line and exit code 2."""


class TopomapError(Exception):
    """Base of every expected error; its text is one line that says what would be right."""


class ConfigError(TopomapError):
    """A configuration file, key or value is wrong."""


class DataError(TopomapError):
    """A file that was read (log, map, data set) is missing, damaged or of another form."""


class RobotFault(DataError):
    """A robot's driver, one of its readings or a full disk ended a run; what was done until then is kept.

    result: what the run wrote all the same, as `topomap.drive` returns it, or None where there was nothing to write.
    """

    def __init__(self, text: str, result: object | None = None) -> None:
        super().__init__(text)
        self.result = result


class ShapeError(TopomapError, ValueError):
    """An array has another shape, type or range than its docstring says."""
