"""What words of a command line mean."""

from __future__ import annotations

import os

from topomap.core.errors import DataError
from topomap.vision.arena import Point


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


def parse_seeds(text: str) -> list[int]:
    """Return the seeds of "0-4", "3" or "0,2,5". Raises DataError."""
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdigit() or (dash and not last.isdigit()) or (dash and int(last) < int(first)):
            raise DataError(f"--seeds {text}: expected numbers like 0-4, 3 or 0,2,5")
        found += range(int(first), int(last or first) + 1)
    return list(dict.fromkeys(found))


def parse_point(text: str | None) -> Point | None:
    """Return the point [m] of "X,Y", None for none. Raises DataError."""
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise DataError(f"--home {text}: expected X,Y in metres, as in 2.0,1.4") from None
    return x, y
