"""The book of closures."""

from __future__ import annotations

import numpy as np
import pytest

from topomap.core.errors import TopomapError
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate, Verdict
from topomap.mapping.closures.ledger import Ledger, key_of


def candidate(query: int, match: int = 1) -> Candidate:
    return Candidate(query, match, match * 10, Pose2(), np.eye(3))


def test_every_decision_is_kept_and_the_last_one_stands() -> None:
    ledger, one, two = Ledger(), candidate(100), candidate(200)
    ledger.decide(100, one, Verdict.PENDING, "waits")
    ledger.decide(200, two, Verdict.REFUSED, "odometry")
    ledger.decide(300, one, Verdict.ACCEPTED, "fits")
    assert [d.reason for d in ledger.decisions] == ["waits", "odometry", "fits"]
    assert ledger.accepted == (one,)
    assert ledger.pending == ()
    assert [d.verdict for d in ledger.history(key_of(one))] == [Verdict.PENDING, Verdict.ACCEPTED]


def test_withdrawing_needs_an_accepted_closure() -> None:
    ledger, one = Ledger(), candidate(100)
    ledger.decide(100, one, Verdict.ACCEPTED, "fits")
    assert ledger.withdraw(200, key_of(one), "by hand").verdict is Verdict.WITHDRAWN
    assert ledger.accepted == ()
    with pytest.raises(TopomapError, match="no accepted closure"):
        ledger.withdraw(300, key_of(one), "again")
