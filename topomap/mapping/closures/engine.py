"""The closure engine: claims in, verdicts with evidence out, by a list of tests that can be read, replaced, extended.

Whoever brings claims, they are weighed here and the verdicts are written down here: a pose graph's all at once
(`batch`), a recording's as its drive goes on (`along_drive`), a robot's own one a step (`online`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.core.records import Candidate, Decision, Verdict
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest, Explains, Knowledge
from topomap.mapping.closures.ledger import Ledger, key_of

ALL = slice(None)


class Weighed(NamedTuple):
    """What the tests say of n claims: log_odds (n,) of true over false, -inf where one refused; failed (n,): which test
    brought a claim below the bar, -1 for none.
    """

    log_odds: FloatArray
    failed: IntArray


class ClosureEngine:
    """Weighs claims by one test after the other and keeps the book of verdicts."""

    def __init__(self, tests: Sequence[ClosureTest] = TESTS, ledger: Ledger | None = None) -> None:
        self.tests = tuple(tests)
        self.ledger = ledger or Ledger()

    def weigh(self, claims: Claims, knowledge: Knowledge, bar: float, stage: slice = ALL) -> Weighed:
        """Return the log odds of n claims; a test that can only lower them isn't asked about those below the bar.

        stage: the part of the list that is asked, where not all can be asked at once.
        """
        odds, failed = np.zeros(len(claims)), np.full(len(claims), -1)
        left, own, known = np.arange(len(claims)), claims, knowledge
        for k, test in list(enumerate(self.tests))[stage]:
            odds[left] += test.weigh(own, known)
            below = odds[left] < (bar if test.lowers else -np.inf)
            out = below | np.isneginf(odds[left])
            if out.any():
                failed[left[out]] = k
                stay = np.flatnonzero(~out)
                left, own, known = left[stay], own[stay], known.among(stay)
        failed[(failed < 0) & (odds < bar)] = len(self.tests) - 1
        return Weighed(odds, failed)

    def reason(self, claims: Claims, knowledge: Knowledge, failed: int) -> str:
        """Return in plain words why a test, given by its place in the list, speaks against a single claim."""
        test = self.tests[failed]
        if isinstance(test, Explains):
            return test.reason(claims, knowledge)
        return f"the test '{test.name}' speaks against it"

    def beside_odometry(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return the log odds of n claims by the tests that may speak for a claim: looks, prevalence, a user's own."""
        return np.asarray(sum((t.weigh(claims, knowledge) for t in self.tests if not t.lowers), np.zeros(len(claims))))

    def decide(self, stamp_ns: int, candidate: Candidate, verdict: Verdict, reason: str) -> Decision:
        """Write a verdict into the ledger, with the reason in plain words, and return it."""
        return self.ledger.decide(stamp_ns, candidate, verdict, reason)

    def verdict(self, candidate: Candidate) -> Verdict | None:
        """Return what was last decided on a candidate."""
        return self.ledger.verdict(key_of(candidate))
