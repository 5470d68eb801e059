"""What words of a command line mean."""

from __future__ import annotations

import os
from collections.abc import Sequence

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


def parse_shares(text: str) -> list[float]:
    """Return the shares of "0,.2,.9", each at least 0 and below 1. Raises DataError."""
    try:
        shares = [float(part) for part in text.split(",")]
    except ValueError:
        shares = [-1.0]
    if not all(0.0 <= share < 1.0 for share in shares):
        raise DataError(f"--shares {text}: expected numbers from 0 to below 1, as in 0,.2,.9")
    return shares


def parse_names(text: str, known: Sequence[str]) -> list[str]:
    """Return names separated by commas; "all" is every known one, "none" no one."""
    return list(known) if text == "all" else [] if text == "none" else text.split(",")


def parse_point(text: str | None) -> Point | None:
    """Return the point [m] of "X,Y", None for none. Raises DataError."""
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise DataError(f"--home {text}: expected X,Y in metres, as in 2.0,1.4") from None
    return x, y
