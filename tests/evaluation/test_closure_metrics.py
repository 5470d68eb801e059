"""Closures judged by the truth, and what could have been closed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from synthetic_run import LAP, candidate, decide, make_run

from topomap.core.geometry import Pose2
from topomap.core.records import UNKNOWN_HEADING, Verdict
from topomap.evaluation.closures import count, judge, passes, recalled, runs_of

RUN = make_run()


def test_a_closure_is_false_beyond_one_metre() -> None:
    near, far = judge(RUN, candidate(RUN, LAP + 9, 0)), judge(RUN, candidate(RUN, LAP + 11, 0))
    assert near is not None
    assert far is not None
    assert (near.false, far.false) == (False, True)
    assert far.distance == pytest.approx(1.1, abs=1e-9)
    assert not far.gross


def test_the_limits_are_the_run_s() -> None:
    wide = replace(RUN, false_distance_m=2.0, gross_distance_m=2.5)
    inside, outside = judge(wide, candidate(RUN, LAP + 11, 0)), judge(wide, candidate(RUN, LAP + 26, 0))
    assert inside is not None
    assert outside is not None
    assert not inside.false
    assert outside.gross


@pytest.mark.parametrize(("degrees", "false"), [(19.0, False), (21.0, True), (-21.0, True), (359.0, False)])
def test_a_closure_is_false_when_turned_by_more_than_twenty_degrees(degrees: float, false: bool) -> None:
    true = candidate(RUN, LAP, 0)
    turned = replace(true, relative=Pose2(0.0, 0.0, true.relative.heading + math.radians(degrees)))
    judgement = judge(RUN, turned)
    assert judgement is not None
    assert judgement.false is false


def test_an_unknown_heading_is_judged_by_distance_alone() -> None:
    assert RUN.truth is not None
    turned = replace(candidate(RUN, LAP, 0), relative=Pose2(0.0, 0.0, 3.0))
    vague = replace(turned, covariance=np.diag([1.0, 1.0, 1.01 * UNKNOWN_HEADING]))
    assert judge(RUN, replace(turned, covariance=np.diag([1.0, 1.0, 0.99 * UNKNOWN_HEADING]))).false  # type: ignore[union-attr]
    headless = replace(RUN, truth=np.column_stack([RUN.truth[:, :2], np.full(len(RUN.stamps_ns), np.nan)]))
    for judgement in (judge(RUN, vague), judge(headless, turned)):
        assert judgement is not None
        assert judgement.rotation_error is None
        assert not judgement.false


def test_without_truth_nothing_is_judged() -> None:
    blind = replace(RUN, truth=None)
    numbers = count(blind)
    assert (numbers.proposed, numbers.accepted) == (4, 3)
    assert (numbers.false, numbers.gross, numbers.possible, numbers.recall) == (None,) * 4


def test_a_candidate_is_counted_once_by_its_last_verdict() -> None:
    numbers = count(RUN)
    assert (numbers.proposed, numbers.accepted, numbers.false, numbers.gross) == (4, 3, 1, 1)
    withdrawn = decide(RUN.decisions[-1].candidate, Verdict.WITHDRAWN, later=9)
    numbers = count(replace(RUN, decisions=(*RUN.decisions, withdrawn)))
    assert (numbers.proposed, numbers.accepted, numbers.false, numbers.gross) == (4, 2, 0, 0)


def test_each_node_is_passed_once_per_lap() -> None:
    found = passes(RUN)
    by_node = {node.node: [p for p in found if p.node == node.node] for node in RUN.nodes}
    assert len(by_node[20]) == 1
    # the last 60 steps are a third visit of the first sixty steps
    assert len(by_node[2]) == 2
    first = by_node[20][0]
    assert LAP + 160 - 8 <= first.first < LAP + 160 < first.last <= LAP + 160 + 8


def test_no_pass_before_ten_metres_of_travel() -> None:
    assert RUN.truth is not None
    straight = RUN.truth.copy()
    straight[:, 0], straight[:, 1] = 0.01 * np.arange(len(straight)), 0.0
    assert passes(replace(RUN, truth=straight)) == ()


def test_recall_counts_passes_near_an_accepted_true_closure() -> None:
    at = LAP + 160
    lone = replace(RUN, decisions=(decide(candidate(RUN, at, 160)),))
    closed = {p.node for p, yes in zip(passes(lone), recalled(lone, passes(lone)), strict=True) if yes}
    # 0.75 m of pass and 1 m of margin either way; nodes lie 0.8 m apart
    assert closed == {18, 19, 20, 21, 22}
    assert count(lone).recall == pytest.approx(5 / len(passes(lone)))


def test_recall_judges_at_the_time_of_decision() -> None:
    true = candidate(RUN, LAP + 160, 160)
    later = replace(RUN, decisions=(decide(true), decide(true, Verdict.WITHDRAWN, later=20)))
    never = replace(RUN, decisions=(decide(true, Verdict.PENDING),))
    false = replace(RUN, decisions=(decide(candidate(RUN, LAP + 160, 40)),))
    assert count(later).recall
    assert count(later).accepted == 0
    assert count(never).recall == 0.0
    assert count(false).recall == 0.0


def test_what_was_withdrawn_counts_as_ever_false_but_closes_nothing_that_stands() -> None:
    at = LAP + 160
    lone = replace(RUN, decisions=(decide(candidate(RUN, at, 160)),))
    # a pass reaches 0.75 m either way of its node, and nodes lie 0.8 m apart
    assert 0 < count(lone).recall_standing < count(lone).recall  # type: ignore[operator]
    true, false = candidate(RUN, at, 160), candidate(RUN, at, 40)
    gone = (decide(false), decide(true), *(decide(c, Verdict.WITHDRAWN, later=20) for c in (false, true)))
    found = count(replace(RUN, decisions=gone))
    assert (found.false, found.false_ever, found.recall_standing) == (0, 1, 0.0)


def test_no_possible_closure_has_no_recall() -> None:
    assert count(replace(RUN, nodes=())).recall is None


def test_runs_of_flags() -> None:
    assert runs_of(np.array([1, 1, 0, 1, 0, 0, 1], dtype=np.bool_)) == [(0, 1), (3, 3), (6, 6)]
    assert runs_of(np.zeros(3, dtype=np.bool_)) == []
