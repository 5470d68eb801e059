"""The closures that were accepted, whether they stand on the map now or a solution took them back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.records import Candidate, Decision, Verdict
from topomap.mapping.closures.ledger import Ledger
from topomap.mapping.graph import TopoMap
from topomap.mapping.optimizer import ClosureEdge, Closures


class Believed:
    """Edges with the candidates they come from, in the order in which they were accepted; one taken back may return."""

    def __init__(self, topo: TopoMap) -> None:
        self._map = topo
        self._closures: list[tuple[ClosureEdge, Candidate]] = []

    def __len__(self) -> int:
        return len(self._closures)

    @property
    def edges(self) -> list[ClosureEdge]:
        """All of them."""
        return [edge for edge, _ in self._closures]

    def add(self, edge: ClosureEdge, candidate: Candidate) -> None:
        """Take one more, which stands on the map."""
        self._closures.append((edge, candidate))

    def recall(self) -> None:
        """Take over those that a loaded map holds."""
        for edge in self._map.closures:
            query, match = self._map.nodes[edge.j].stamp_ns, self._map.nodes[edge.i].stamp_ns
            self.add(edge, Candidate(query, edge.i, match, edge.relative, edge.covariance, query=edge.j))

    def standing(self) -> Closures:
        """Return those that the map holds now."""
        on_map = self._on_map
        return Closures.of([edge for edge in self.edges if (edge.i, edge.j) in on_map])

    def doubted(self) -> BoolArray:
        """Return which of all (M,) the map does without."""
        on_map = self._on_map
        return np.array([(edge.i, edge.j) not in on_map for edge in self.edges], bool)

    def review(self, stamp_ns: int, ledger: Ledger, heard: Sequence[int], weights: FloatArray) -> list[Decision]:
        """Withdraw what a solution disbelieves and take back what it believes again; each stays for later solves.

        heard: which of all were asked; weights (len(heard),): what they count there.
        """
        changed = []
        on_map = self._on_map
        for k, weight in zip(heard, weights.tolist(), strict=True):
            edge, candidate = self._closures[k]
            standing = (edge.i, edge.j) in on_map
            if weight < 0.5 and standing:
                reason = "the back end can't fit it beside the other evidence"
                changed.append(self._withdraw(stamp_ns, ledger, edge, candidate, reason))
            elif weight >= 0.5 and not standing:
                self._map.close(edge)
                changed.append(ledger.decide(stamp_ns, candidate, Verdict.ACCEPTED, "fits after all"))
        return changed

    def forget(self, stamp_ns: int, ledger: Ledger, behind: set[int], reason: str) -> tuple[bool, list[Decision]]:
        """Let go for good of those that join nodes `behind` a gap with others; return whether there were any."""
        across = [(edge.i in behind) != (edge.j in behind) for edge in self.edges]
        on_map = self._on_map
        gone = [own for own, over in zip(self._closures, across, strict=True) if over]
        changed = [
            self._withdraw(stamp_ns, ledger, edge, candidate, reason)
            for edge, candidate in gone
            if (edge.i, edge.j) in on_map
        ]
        self._closures = [own for own, over in zip(self._closures, across, strict=True) if not over]
        return bool(gone), changed

    def withdraw_all(self, stamp_ns: int, ledger: Ledger, reason: str) -> None:
        """Take all that stand off the map."""
        on_map = self._on_map
        for edge, candidate in self._closures:
            if (edge.i, edge.j) in on_map:
                self._withdraw(stamp_ns, ledger, edge, candidate, reason)

    def _withdraw(
        self, stamp_ns: int, ledger: Ledger, edge: ClosureEdge, candidate: Candidate, reason: str
    ) -> Decision:
        self._map.remove(edge)
        return ledger.decide(stamp_ns, candidate, Verdict.WITHDRAWN, reason)

    @property
    def _on_map(self) -> set[tuple[int, int]]:
        """The pairs of nodes that closures join now."""
        return {(c.i, c.j) for c in self._map.closures}
