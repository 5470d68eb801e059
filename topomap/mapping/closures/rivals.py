"""Several solutions of one drive compete, and the likeliest is kept."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from topomap.core.arrays import BoolArray
from topomap.mapping.closures.batch import Batch, Judgement, Told, quiet
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest
from topomap.mapping.closures.drive import Drive

GROWN, AT_ONCE, ODOMETRY = "grown from the likeliest closures", "begun with all closures at once", "odometry"
OPEN = 0.01  # undecided clusters for one that stands, up to which a solution is as good as complete


class Solution(NamedTuple):
    """One solution: how it was found, what came of it, which claims (M,) are in, and the log odds of all these."""

    name: str
    batch: Batch
    inlier: BoolArray
    evidence: float


def likeliest(drive: Drive, claims: Claims, tests: Sequence[ClosureTest] = TESTS, told: Told = quiet) -> Judgement:
    """Return the verdicts of that solution which makes all that is claimed likeliest; odometry alone is one of them.

    A map may grow from the likeliest closures on, or begin with all that odometry allows, robustly. Where the first
    leaves nothing undecided, the second isn't tried.
    """
    batch = Batch(drive, claims, tests, told)
    if not drive.held:
        return batch.run()
    names = (AT_ONCE, GROWN) if batch.mostly_true else (GROWN, AT_ONCE)
    found = [_solved(names[0], batch)]
    if not _complete(batch) and (names[1] == GROWN or batch.pulls_quickly):
        found.append(_solved(names[1], batch.again()))
    best = max(found, key=lambda solution: solution.evidence)
    if best.evidence <= 0.0:
        best.inlier[:] = False
    return best.batch.judgement(best.inlier)


def _solved(name: str, batch: Batch) -> Solution:
    if name == GROWN:
        batch.grow()
    else:
        batch.pull_all()
    batch.settle()
    inlier = batch.confirm()
    return Solution(name, batch, inlier, batch.evidence())


def _complete(batch: Batch) -> bool:
    return batch.standing_clusters > 0 and batch.undecided() <= OPEN * batch.standing_clusters
