"""The odometry along a map's chain: each edge's increments as declared, and as the data judges them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from topomap.mapping.odometry.increments import EdgeIncrements, Increments
from topomap.mapping.odometry.noise import AS_DECLARED, OdometerNoise

Ends = tuple[int, int]
"""The two nodes that an edge joins, in travel order."""


class ChainIncrements:
    """Increments by the edge's ends, as declared; `judged` gives them with the covariances that the data leaves them.

    noise: what the declared variances are taken times.
    """

    def __init__(self) -> None:
        self.noise = AS_DECLARED
        self._declared: dict[Ends, Increments] = {}
        self._judged: dict[Ends, Increments] = {}
        self._parts: list[Increments] = []  # of which `whole` was made last
        self._whole = EdgeIncrements.of([])

    def __getitem__(self, ends: Ends) -> Increments:
        return self._declared[ends]

    def __setitem__(self, ends: Ends, increments: Increments) -> None:
        self._declared[ends] = increments
        self._judged.pop(ends, None)

    def pop(self, ends: Ends) -> Increments:
        """Return an edge's increments and forget them."""
        self._judged.pop(ends, None)
        return self._declared.pop(ends)

    def judge(self, noise: OdometerNoise) -> None:
        """Take the odometry's errors for what the data says."""
        self.noise = noise
        self._judged.clear()

    def judged(self, edges: Sequence[Ends]) -> list[Increments]:
        """Return the increments of edges with their covariances as judged; those that weren't yet are at once."""
        new = [ends for ends in edges if ends not in self._judged]
        if new:
            declared = [self._declared[ends] for ends in new]
            self._judged.update(zip(new, self._judging(declared), strict=True))
        return [self._judged[ends] for ends in edges]

    def whole(self, edges: Sequence[Ends]) -> EdgeIncrements:
        """Return the increments of all edges as judged, in one piece; what it shares with the last one is kept."""
        parts = self.judged(edges)
        known = next((k for k, (a, b) in enumerate(zip(self._parts, parts, strict=False)) if a is not b),
                     min(len(self._parts), len(parts)))  # fmt: skip
        self._whole = self._whole.first(known).followed_by(EdgeIncrements.of(parts[known:]))
        self._parts = parts
        return self._whole

    def set_back(self, back: int) -> None:
        """Set all stamps back [ns]."""
        for ends, own in self._declared.items():
            self._declared[ends] = replace(own, stamps_ns=own.stamps_ns - back)
        self._judged.clear()

    def _judging(self, declared: Sequence[Increments]) -> list[Increments]:
        if self.noise is AS_DECLARED:
            return list(declared)
        whole = self.noise.judged(Increments.concatenate(declared))
        last = np.cumsum([len(own) for own in declared]).tolist()
        return [whole[a:b] for a, b in zip([0, *last], last, strict=False)]
