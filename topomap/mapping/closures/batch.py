"""All claims about a drive at once: several solutions compete, and the one that makes all that is claimed likeliest
is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray, IntArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import TESTS, ClosureTest
from topomap.mapping.closures.drive import Drive, MapState
from topomap.mapping.closures.evidence import log_evidence
from topomap.mapping.closures.growing import grow, mostly_true, pull_all, pulls_quickly
from topomap.mapping.closures.settling import confirm, settle, undecided
from topomap.mapping.closures.working_map import SEVERAL, SURE, Told, WorkingMap

OPEN = 0.01  # undecided clusters for one that stands, up to which a solution is as good as complete
LESS_SURE = (2.0, 4.0)  # times the stated sigmas that odometry may have, where it fits its closures badly
# squared error of a solution for each thing its closures claim: it is 1 where sigmas are true, .15 on CSAIL, .57 on
# intel, .95 on manhattan, up to 3.4 on drives whose odometry turned by 10 % more than it said
TENSE = 1.5
# undecided clusters for one that stands, from which on it is much: up to .14 on CSAIL, .15 to 3 on such drives
MUCH = 0.15
TELLING = 30  # clusters that stand, of which the tension is known to a tenth; fewer, let in as they fit, tell little

Begin = Callable[[WorkingMap], None]
NAMES: dict[Begin, str] = {grow: "grown from the likeliest on", pull_all: "begun with all that odometry allows"}


def quiet(_share: float, _doing: str) -> None:
    """Tell nobody how far the work is."""


@dataclass(frozen=True, slots=True, eq=False)
class Judgement:
    """What became of M claims: the map, which are inliers (M,), their log odds (M,) and why, in plain words (M,).

    kept: which of several solutions the map is, and why.
    """

    state: MapState
    inlier: BoolArray
    log_odds: FloatArray
    reason: tuple[str, ...]
    kept: str


class _Solution(NamedTuple):
    """A solution: its map, how it was begun, the log odds of all that stands in it, and the squared error for each
    thing that its closures claim.
    """

    working: WorkingMap
    how: str
    evidence: float
    tension: float


class Batch:
    """Judges all claims about a drive.

    Claims of neighbouring places that agree are one piece of evidence, a cluster. Those that odometry can't explain are
    refused, and tell how often such claims are true. A map grows from the likeliest closures on, or begins with all of
    them and lets go what doesn't fit; where the first way leaves nothing undecided the other isn't tried. Each finished
    map is tested closure by closure. Of several, and of odometry alone, the one with the most evidence is kept. Where
    that leaves much undecided, odometry may be less sure than it says: with wider sigmas it refuses less, and what is
    claimed is as likely as it ever gets where these are right.
    """

    def __init__(self, drive: Drive, claims: Claims, tests: Sequence[ClosureTest] = TESTS, told: Told = quiet) -> None:
        """Take a drive and claims in order of i, then of j; told: hears the share done and what is being done."""
        self._working = WorkingMap(drive, claims, tests, told)
        self._tests = tests

    def run(self) -> Judgement:
        """Return the verdicts on all claims."""
        if not self._working.drive.held:  # evidence isn't reckoned over what is unknown of the odometry
            return self.grown()
        best = _best(self._working)
        if _doubtful(best):
            best = self._less_sure(best)
        if not best.evidence > 0.0:
            best.working.standing = best.working.standing[:0]
        return _judged(best.working, best.how)

    def grown(self) -> Judgement:
        """Return the verdicts by the map that grows from the likeliest on, as it is settled, without any rival."""
        working = self._working.again()
        grow(working)
        settle(working)
        return _judged(working, NAMES[grow])

    def _less_sure(self, best: _Solution) -> _Solution:
        """Return a solution with an odometry less sure than stated, if it is sure to be better than the best so far."""
        stated = self._working
        for times in LESS_SURE:
            wider = WorkingMap(stated.drive.less_sure(times), stated.claims, self._tests, stated.told)
            other = _best(wider)
            how = f"{other.how}, odometry being {times:g} times less sure than stated"
            surely = other._replace(how=how, evidence=other.evidence - SURE)
            if len(other.working.standing_clusters()) >= SEVERAL:  # fewer may be false just as well
                best = max(best, surely, key=lambda solution: solution.evidence)
        return best


def _best(working: WorkingMap) -> _Solution:
    """Return the solution with the most evidence, of as many as it takes."""
    ways: list[Begin] = [grow]
    if pulls_quickly(working):
        ways = [pull_all, grow] if mostly_true(working) else [grow, pull_all]
    found: list[_Solution] = []
    ends: list[IntArray] = []
    for way in ways:
        other = working.again()
        way(other)
        settle(other)
        if any(np.array_equal(other.standing, end) for end in ends):
            continue  # it is the same map, but for rounding, which is not to choose between two ways
        ends.append(other.standing)
        found.append(_finished(other, NAMES[way]))
        if _complete(other):
            break
    return max(found, key=lambda solution: solution.evidence)


def _doubtful(best: _Solution) -> bool:
    """Whether much is open and odometry may be less sure than stated: what stands strains it, or can hardly tell."""
    if _complete(best.working):
        return False
    standing = len(best.working.standing_clusters())
    return best.tension > TENSE or (standing < TELLING and undecided(best.working) >= MUCH * standing)


def _finished(working: WorkingMap, how: str) -> _Solution:
    """Return a settled map as a solution: what its closures don't make likely taken out, and how likely the rest is."""
    confirm(working)
    ones = working.ones()
    found = log_evidence(working.drive, working.map, working.claims[ones], working.prior_odds(ones))
    return _Solution(working, how, found.log_odds, found.tension)


def _complete(working: WorkingMap) -> bool:
    """Whether next to nothing is left of which the finished map can't tell whether it is true."""
    standing = len(working.standing_clusters())
    return standing > 0 and undecided(working) <= OPEN * standing


def _judged(working: WorkingMap, how: str) -> Judgement:
    inlier = np.isin(np.arange(len(working.claims)), working.standing)
    count = int(inlier.sum())
    working.told(1.0, f"{count} closures")
    if not count:
        reasons = _reasons(working, inlier)
        return Judgement(working.drive.start(), inlier, working.odds, reasons, "odometry: nothing is likely")
    kept = f"{count} of {len(inlier)} closures are likely, {how}"
    return Judgement(working.map, inlier, working.odds, _reasons(working, inlier), kept)


def _reasons(working: WorkingMap, inlier: BoolArray) -> tuple[str, ...]:
    """Return why each claim is in or out."""
    allowed = working.allowed[working.clusters.label]
    words = np.where(inlier, "fits the map with all other closures", "the map makes it unlikely")
    words = np.where(~inlier & (working.odds >= SURE), "likely, but the map can't fit it beside the others", words)
    return tuple(np.where(allowed, words, "odometry contradicts it").tolist())
