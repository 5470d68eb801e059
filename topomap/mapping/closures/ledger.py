"""The book of closures: pending, accepted, refused and withdrawn, with every decision kept in order."""

from __future__ import annotations

from dataclasses import dataclass, field

from topomap.core.errors import TopomapError
from topomap.core.records import Candidate, Decision, Verdict

Key = tuple[int, int]


def key_of(candidate: Candidate) -> Key:
    """Return what identifies a candidate: the stamps [ns] of its query and of its match."""
    return candidate.query_ns, candidate.match_ns


@dataclass
class Ledger:
    """Where each candidate stands now, and how it came there; a candidate is known by `key_of`."""

    decisions: list[Decision] = field(default_factory=list)
    _latest: dict[Key, Decision] = field(default_factory=dict)

    def decide(self, stamp_ns: int, candidate: Candidate, verdict: Verdict, reason: str) -> Decision:
        """Record a verdict at stamp_ns [ns]; a later one on the same candidate replaces the standing one."""
        decision = Decision(stamp_ns, candidate, verdict, reason)
        self.decisions.append(decision)
        self._latest[key_of(candidate)] = decision
        return decision

    def withdraw(self, stamp_ns: int, key: Key, reason: str) -> Decision:
        """Withdraw an accepted closure; raises TopomapError when none is accepted under that key."""
        standing = self._latest.get(key)
        if standing is None or standing.verdict is not Verdict.ACCEPTED:
            raise TopomapError(f"no accepted closure between stamps {key[0]} and {key[1]} to withdraw")
        return self.decide(stamp_ns, standing.candidate, Verdict.WITHDRAWN, reason)

    def verdict(self, key: Key) -> Verdict | None:
        """Return the standing verdict of a candidate, or None for an unknown one."""
        standing = self._latest.get(key)
        return None if standing is None else standing.verdict

    def history(self, key: Key) -> tuple[Decision, ...]:
        """Return every decision on a candidate, oldest first."""
        return tuple(d for d in self.decisions if key_of(d.candidate) == key)

    def standing(self, verdict: Verdict) -> tuple[Candidate, ...]:
        """Return the candidates whose standing verdict is this one, in the order they were first decided."""
        return tuple(d.candidate for d in self._latest.values() if d.verdict is verdict)

    @property
    def accepted(self) -> tuple[Candidate, ...]:
        """The closures that stand."""
        return self.standing(Verdict.ACCEPTED)

    @property
    def pending(self) -> tuple[Candidate, ...]:
        """The candidates that wait for more evidence."""
        return self.standing(Verdict.PENDING)
