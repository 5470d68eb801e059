"""Somebody else's words made safe: as the name of a file, as a line on a terminal."""

from __future__ import annotations

import re
import unicodedata

LONGEST = 100  # characters of a file's name: less than any file system takes, with room for an ending
_UNSAFE = re.compile(r"[^\w.=+-]+")
_HARMLESS = "\n\t"


def safe_name(text: str) -> str:
    """Return a text as the name of one file or folder: no separators, no leading dot, never empty."""
    name = _UNSAFE.sub("_", text).lstrip(".")[:LONGEST]
    return name or "unnamed"


def printable(text: str) -> str:
    """Return a text in which what would steer a terminal (escape, control and direction marks) is written out."""
    if text.isprintable():
        return text
    return "".join(c if c in _HARMLESS or not _steers(c) else repr(c)[1:-1] for c in text)


def _steers(character: str) -> bool:
    return unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")
