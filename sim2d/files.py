"""Files that are read whole: a pipe that nobody writes to would be waited for, and a device has no end."""

from __future__ import annotations

import errno
import stat
from pathlib import Path

MOST = 4 * 2**20
"""[bytes] Most that a world's file or a floor plan's YAML file has."""


def regular(path: Path, most: int = MOST) -> Path:
    """Return the path of a file that can be read whole. Raises OSError for anything else, or if it is too large."""
    state = path.stat()
    if not stat.S_ISREG(state.st_mode) and not stat.S_ISDIR(state.st_mode):
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    if state.st_size > most:
        raise OSError(errno.EFBIG, f"{state.st_size} bytes are more than the {most} that are read", str(path))
    return path
