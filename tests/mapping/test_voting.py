"""Closures that wait for others that agree, in either driving direction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.closures.voting import Voting
from topomap.mapping.graph import Node, TopoMap


def road(there_and_back: bool) -> TopoMap:
    """Nodes 0..19 every metre along x, then 20..39 along it again, or back, with the map 2 m off by then."""
    topo = TopoMap()
    for k in range(40):
        x = k if k < 20 else (39 - k if there_and_back else k - 20)
        node = topo._store(Node(k, float(k), None), np.array([x, 0.0, 0.0]), k)
        heading = math.pi if there_and_back and k >= 20 else 0.0
        topo.poses[node] = [x + (2.0 if k >= 20 else 0.0), 0.0, heading]
    return topo


def candidate(query: int, match: int, rotation: float, ratio: float = 0.0) -> Candidate:
    relative = Pose2(0.0, 0.0, rotation)
    return Candidate(query, match, match, relative, np.eye(3), query=query, evidence=Evidence(ratio=ratio))


def add(voting: Voting, one: Candidate) -> tuple[Candidate, ...]:
    """All that are believed with a candidate, or none yet."""
    company = voting.add(one)
    if company.support < 1.0:
        return ()
    voting.settle(company)
    return company.agreeing


@pytest.mark.parametrize("back", [False, True])
def test_three_that_tell_the_same_shift_are_believed_together(back: bool) -> None:
    voting = Voting(road(back))
    pairs = [(query, 39 - query if back else query - 20) for query in (22, 24, 26)]
    turn = math.pi if back else 0.0
    assert add(voting, candidate(*pairs[0], turn)) == ()
    assert add(voting, candidate(*pairs[1], turn)) == ()
    assert [c.query for c in add(voting, candidate(*pairs[2], turn))] == [22, 24, 26]


def test_places_that_hardly_beat_their_rivals_need_more_of_them() -> None:
    voting = Voting(road(False))
    found = [add(voting, candidate(20 + k, k, 0.0, ratio=0.875)) for k in range(6)]  # half a vote each
    assert [len(some) for some in found] == [0, 0, 0, 0, 0, 6]


def test_an_active_check_is_a_further_vote() -> None:
    voting = Voting(road(False))
    first, second = candidate(22, 2, 0.0), candidate(24, 4, 0.0)
    assert add(voting, first) == ()
    assert add(voting, second) == ()
    voting.drop(first)
    checked = replace(first, evidence=replace(first.evidence, active=1.0))
    assert add(voting, checked) == (second, checked)


def test_what_was_dropped_supports_nothing() -> None:
    voting = Voting(road(False))
    first = candidate(22, 2, 0.0)
    add(voting, first)
    add(voting, candidate(23, 3, 0.0))
    voting.drop(first)
    assert add(voting, candidate(24, 4, 0.0)) == ()
    assert len(add(voting, candidate(25, 5, 0.0))) == 3


def test_look_alikes_at_random_places_never_agree() -> None:
    voting = Voting(road(False))
    for query, match in ((22, 2), (23, 9), (24, 1), (25, 13), (26, 10)):
        assert add(voting, candidate(query, match, 0.0)) == ()


def test_a_wrong_rotation_does_not_agree() -> None:
    voting = Voting(road(False))
    assert add(voting, candidate(22, 2, 0.0)) == ()
    assert add(voting, candidate(23, 3, 0.0)) == ()
    assert add(voting, candidate(24, 4, 0.2)) == ()  # 11 degrees
    assert [c.query for c in add(voting, candidate(25, 5, 0.0))] == [22, 23, 25]


def test_what_nothing_supports_in_time_expires_once() -> None:
    voting = Voting(road(False))
    add(voting, candidate(22, 2, 0.0))
    assert voting.expired(29.9) == ()
    assert [c.query for c in voting.expired(30.1)] == [22]
    assert voting.expired(40.0) == ()
