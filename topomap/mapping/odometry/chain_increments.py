"""The odometry along a map's chain: each edge's increments as declared, and as the data judges them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from topomap.mapping.odometry.increments import Calibration, EdgeIncrements, Increments
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
        self._settled: set[Ends] = set()  # what is kept of these was judged once for all
        self._judged: dict[Ends, Increments] = {}
        self._parts: list[Increments] = []  # of which `whole` was made last, as declared,
        self._whole = EdgeIncrements.of([])  # in one piece,
        self._as_judged = (AS_DECLARED, self._whole)  # and as judged by which noise

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

    def settle(self) -> None:
        """Let all edges so far be as sure as they say: those of a loaded map, whose odometry was judged then."""
        self._settled = set(self._declared)
        self.judge(self.noise)
        self._parts = []

    def judged(self, edges: Sequence[Ends]) -> list[Increments]:
        """Return the increments of edges with their covariances as judged; those that weren't yet are at once."""
        new = [ends for ends in edges if ends not in self._judged]
        if new:
            declared = [self._declared[ends] for ends in new]
            whole = self._judging(EdgeIncrements.of(declared), new)
            for k, (ends, own) in enumerate(zip(new, declared, strict=True)):
                part = slice(*whole.starts[k : k + 2])
                self._judged[ends] = Increments(own.stamps_ns, own.deltas, whole.covariances[part])
        return [self._judged[ends] for ends in edges]

    def whole(self, edges: Sequence[Ends]) -> EdgeIncrements:
        """Return the increments of all edges as judged, in one piece; what it shares with the last one is kept."""
        parts = [self._declared[ends] for ends in edges]
        known = next((k for k, (a, b) in enumerate(zip(self._parts, parts, strict=False)) if a is not b),
                     min(len(self._parts), len(parts)))  # fmt: skip
        new = EdgeIncrements.of(parts[known:])
        self._parts, self._whole = parts, self._whole.first(known).followed_by(new)
        noise, judged = self._as_judged
        if noise == self.noise:
            judged = judged.first(known).followed_by(self._judging(new, edges[known:]))
        else:
            judged = self._judging(self._whole, edges)
        self._as_judged = self.noise, judged
        return judged

    def set_back(self, back: int) -> None:
        """Set all stamps back [ns]."""
        for ends, own in self._declared.items():
            self._declared[ends] = replace(own, stamps_ns=own.stamps_ns - back)
        self._judged.clear()

    def read_by(self, edges: Sequence[Ends], theirs: Calibration, ours: Calibration) -> None:
        """Let some edges say what an odometer with errors `ours` would have read; one with errors `theirs` did."""
        declared = [self._declared[ends] for ends in edges]
        whole = EdgeIncrements.of(declared).read_by(theirs, ours)
        for k, (ends, own) in enumerate(zip(edges, declared, strict=True)):
            part = slice(*whole.starts[k : k + 2])
            self[ends] = Increments(own.stamps_ns, whole.deltas[part], whole.covariances[part])

    def _judging(self, declared: EdgeIncrements, edges: Sequence[Ends]) -> EdgeIncrements:
        if self.noise is AS_DECLARED:
            return declared
        judged = self.noise.covariances(declared)
        if self._settled:
            settled = np.repeat(np.array([ends in self._settled for ends in edges], bool), np.diff(declared.starts))
            judged[settled] = declared.covariances[settled]
        return replace(declared, covariances=judged)
