"""Python's garbage collector is kept from walking over the whole map in the middle of a step."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

NEVER = 2**31 - 1  # collections of what is younger before such a walk: the most that Python takes


@contextmanager
def short_pauses() -> Iterator[None]:
    """Put off the collector's walk over all that has lived long, which is the map, until the drive is over.

    It took 0.23 s at 13,000 nodes and freed nothing: a step leaves no objects that hold one another. What is young is
    collected as ever, and what nobody holds any more is freed at once.
    """
    before = gc.get_threshold()
    gc.set_threshold(before[0], before[1], NEVER)
    try:
        yield
    finally:
        gc.set_threshold(*before)
