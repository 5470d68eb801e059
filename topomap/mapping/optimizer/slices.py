"""Work that is done a slice at a time."""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

T = TypeVar("T")
Slices = Generator[None, None, T]


def drained(slices: Slices[T]) -> T:
    """Return what all slices, one after the other, end with."""
    while True:
        try:
            next(slices)
        except StopIteration as end:
            found: T = end.value
            return found
