"""Loop closures judged by the truth, and the passes that could have been closed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.evidence import FALSE_ROTATION
from topomap.core.geometry import wrap
from topomap.core.records import UNKNOWN_HEADING, Candidate, Decision, Verdict
from topomap.core.run_data import RunData
from topomap.evaluation.trajectory import step_at, travel, true_pose

PASS_RADIUS_M = 0.75
PASS_TRAVEL_M = 10.0
PASS_MARGIN_M = 1.0


@dataclass(frozen=True, slots=True)
class Judgement:
    """What the truth says: distance of the two true poses [m]; rotation claimed minus true [rad], None where
    the truth or the claim has no heading; false and gross by the run's limits (gross: by distance alone)."""

    distance: float
    rotation_error: float | None
    false: bool
    gross: bool


@dataclass(frozen=True, slots=True)
class Closure:
    """One candidate (query stamp and match node) with all its decisions in time order, and what the truth
    says."""

    candidate: Candidate
    decisions: tuple[Decision, ...]
    judgement: Judgement | None

    @property
    def verdict(self) -> Verdict:
        """Return the last verdict, the one that the final map holds."""
        return self.decisions[-1].verdict

    @property
    def reason(self) -> str:
        """Return the reason of the last verdict."""
        return self.decisions[-1].reason

    @property
    def once_accepted(self) -> bool:
        """Return whether it was accepted when it was decided, though perhaps withdrawn later."""
        return any(decision.verdict is Verdict.ACCEPTED for decision in self.decisions)


@dataclass(frozen=True, slots=True)
class Pass:
    """A contiguous stretch of steps [first, last] within 0.75 m of an earlier node, all at least 10 m of
    travel on."""

    node: int
    first: int
    last: int


@dataclass(frozen=True, slots=True)
class ClosureCounts:
    """Candidates proposed and, by their last verdict, accepted; of the accepted: false and gross; passes
    possible and the share of them recalled. None where the truth is missing; recall also where nothing was
    possible.

    false_ever: false ones that were accepted at any time, though perhaps withdrawn later; recall_standing: the share
    of passes with a closure of the finished map within them, without a margin.
    """

    proposed: int
    accepted: int
    false: int | None
    gross: int | None
    possible: int | None
    recall: float | None
    false_ever: int | None = None
    recall_standing: float | None = None


def closures(run: RunData) -> tuple[Closure, ...]:
    """Return every candidate of the run, in the order of first decision."""
    return tuple(_closure(run, own) for own in _histories(run))


def accepted(run: RunData) -> tuple[Closure, ...]:
    """Return the closures that the final map holds."""
    return tuple(_closure(run, own) for own in _histories(run) if own[-1].verdict is Verdict.ACCEPTED)


def _histories(run: RunData) -> list[list[Decision]]:
    histories: dict[tuple[int, int], list[Decision]] = {}
    for decision in run.decisions:
        histories.setdefault((decision.candidate.query_ns, decision.candidate.match), []).append(decision)
    return list(histories.values())


def _closure(run: RunData, own: list[Decision]) -> Closure:
    return Closure(own[-1].candidate, tuple(own), judge(run, own[-1].candidate))


def judge(run: RunData, candidate: Candidate) -> Judgement | None:
    """Return what the truth says of a candidate, at the steps nearest to its stamps; None where it is
    unknown.

    False: true poses more than `false_distance_m` apart, or their rotation more than 20 degrees from the
    claimed one. Gross: more than `gross_distance_m` apart.
    """
    if run.truth is None:
        return None
    query, match = true_pose(run, candidate.query_ns), true_pose(run, candidate.match_ns)
    distance = math.hypot(query[0] - match[0], query[1] - match[1])
    if math.isnan(distance):
        return None
    rotation = _rotation_error(candidate, query, match)
    turned = rotation is not None and abs(rotation) > FALSE_ROTATION
    return Judgement(distance, rotation, distance > run.false_distance_m or turned, distance > run.gross_distance_m)


def _rotation_error(candidate: Candidate, query: FloatArray, match: FloatArray) -> float | None:
    true = float(query[2] - match[2])
    claimed = candidate.relative.heading
    variance = float(candidate.covariance[2, 2])
    if not math.isfinite(true) or not variance <= UNKNOWN_HEADING:
        return None
    return wrap(claimed - true)


def passes(run: RunData) -> tuple[Pass, ...]:
    """Return the possible closures; empty without truth.

    There is one per snapshot node and contiguous stretch of steps that lie, in truth, within 0.75 m of where
    that node was taken and at least 10 m of true travel after it.
    """
    if run.truth is None:
        return ()
    path, places = travel(run.truth), run.truth[:, :2]
    found: list[Pass] = []
    for node in (node for node in run.nodes if node.snapshot):
        late = 0  # a node of an earlier drive can be passed from the first step on
        if node.stamp_ns >= run.stamps_ns[0]:
            late = int(np.searchsorted(path, path[step_at(run.stamps_ns, node.stamp_ns)] + PASS_TRAVEL_M))
        gaps = places[late:] - true_pose(run, node.stamp_ns)[:2]
        near = (gaps**2).sum(axis=1) <= PASS_RADIUS_M**2
        found += [Pass(node.node, late + first, late + last) for first, last in runs_of(near)]
    return tuple(found)


def runs_of(flags: BoolArray) -> list[tuple[int, int]]:
    """Return first and last index of each contiguous run of true flags (N,)."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return [(int(a), int(b) - 1) for a, b in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0), strict=True)]


def recalled(run: RunData, possible: tuple[Pass, ...]) -> BoolArray:
    """Return, for each of `possible` (P,), whether it was closed.

    A pass is closed when any true closure that was accepted when decided (a later withdrawal doesn't undo
    that, a pending or refused one doesn't count) has its query stamp within the pass, or within 1 m of true
    travel of it. Which node the closure matched doesn't matter: two neighbouring nodes are one place.
    """
    return _closed(run, possible, [c for c in closures(run) if c.once_accepted], PASS_MARGIN_M)


def recalled_standing(run: RunData, possible: tuple[Pass, ...]) -> BoolArray:
    """Return, for each of `possible` (P,), whether a true closure of the finished map has its query within it."""
    return _closed(run, possible, list(accepted(run)), 0.0)


def _closed(run: RunData, possible: tuple[Pass, ...], by: list[Closure], margin: float) -> BoolArray:
    true = [c for c in by if c.judgement is not None and not c.judgement.false]
    if run.truth is None or not true or not possible:
        return np.zeros(len(possible), dtype=np.bool_)
    path = travel(run.truth)
    queries = np.sort([path[step_at(run.stamps_ns, c.candidate.query_ns)] for c in true])
    before = np.searchsorted(queries, path[[p.first for p in possible]] - margin, side="left")
    until = np.searchsorted(queries, path[[p.last for p in possible]] + margin, side="right")
    return until > before


def count(run: RunData) -> ClosureCounts:
    """Return the closures in numbers."""
    every = closures(run)
    kept = [closure for closure in every if closure.verdict is Verdict.ACCEPTED]
    if run.truth is None:
        return ClosureCounts(len(every), len(kept), None, None, None, None)
    judged = [closure.judgement for closure in kept if closure.judgement is not None]
    possible = passes(run)
    closed, standing = recalled(run, possible), recalled_standing(run, possible)
    ever = [closure.judgement for closure in every if closure.once_accepted and closure.judgement is not None]
    return ClosureCounts(
        proposed=len(every),
        accepted=len(kept),
        false=sum(judgement.false for judgement in judged),
        gross=sum(judgement.gross for judgement in judged),
        possible=len(closed),
        recall=float(closed.mean()) if len(closed) else None,
        false_ever=sum(judgement.false for judgement in ever),
        recall_standing=float(standing.mean()) if len(standing) else None,
    )
