"""Workers hand on each result as it comes, so that what a bench has done outlives it."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from topomap.bench.pool import Store, workers


@dataclass(frozen=True)
class Halved:
    """Half of a number; odd ones can't be."""

    number: int

    @property
    def key(self) -> str:
        return f"{self.number}"

    def perform(self) -> int:
        if self.number % 2:
            raise ValueError("odd")
        return self.number // 2


def test_results_are_taken_as_they_come() -> None:
    taken: list[int] = []
    with workers(1, Store(None)) as hands, pytest.raises(ValueError, match="odd"):
        hands.run([Halved(2), Halved(4), Halved(5), Halved(6)], lambda: None, taken.append)
    assert taken == [1, 2]
