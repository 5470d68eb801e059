"""What travelling has taught of the map's edges: how often each was passed, failed, and how long it took."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class EdgeExperience:
    """What is known of driving from node `a` to node `b`, in this direction.

    passed, failed: how often; seconds: mean time of a passage [s]; failed_ns: stamp of the last failure, 0 for none.
    """

    a: int
    b: int
    passed: int = 0
    failed: int = 0
    seconds: float = 0.0
    failed_ns: int = 0


class Experience:
    """The experience of all edges that were ever driven on a journey; the map keeps it."""

    def __init__(self, rows: Iterable[EdgeExperience] = ()) -> None:
        self._rows = {(row.a, row.b): row for row in rows}

    def __iter__(self) -> Iterator[EdgeExperience]:
        """Yield the rows in the order of their nodes."""
        return iter(self._rows[key] for key in sorted(self._rows))

    def __len__(self) -> int:
        return len(self._rows)

    def of(self, a: int, b: int) -> EdgeExperience:
        """Return what is known of the way from a to b."""
        return self._rows.get((a, b)) or EdgeExperience(a, b)

    def passed(self, a: int, b: int, seconds: float) -> None:
        """Note a passage that took so long [s]."""
        row = self.of(a, b)
        mean = (row.seconds * row.passed + seconds) / (row.passed + 1)
        self._rows[a, b] = replace(row, passed=row.passed + 1, seconds=mean)

    def failed(self, a: int, b: int, stamp_ns: int) -> None:
        """Note a failure at a stamp."""
        row = self.of(a, b)
        self._rows[a, b] = replace(row, failed=row.failed + 1, failed_ns=stamp_ns)
