"""Files that are read whole: a pipe that nobody writes to would be waited for, and a device has no end."""

from __future__ import annotations

import errno
import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

TEXT, TABLE = 4 * 2**20, 200 * 2**20
"""[bytes] Most that a file of settings, a rig or a world has, and one of numbers or a picture: a pose graph of a
million edges has 100 MB, and takes five times as much while it is read."""


def regular(path: Path, most: int = TABLE) -> Path:
    """Return the path of a file that can be read whole. Raises OSError for anything else, or if it is too large."""
    state = path.stat()
    if stat.S_ISDIR(state.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(state.st_mode):
        raise OSError(errno.EINVAL, "it is no regular file", str(path))
    if state.st_size > most:
        raise OSError(errno.EFBIG, f"{state.st_size} bytes are more than the {most} that are read", str(path))
    return path


DEEP = re.compile(r"(?<![\w\"'-])(?:[\w\"'-]+\s*\.\s*){64}")
"""A key of so many parts: reading one takes the square of their number."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file. Raises OSError, ValueError, RecursionError."""
    text = regular(path, TEXT).read_text(encoding="utf8")
    if DEEP.search(text):
        raise ValueError("a key has more than 64 parts")
    return tomllib.loads(text)
