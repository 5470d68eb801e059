"""Closures that wait for others that agree, in either driving direction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from topomap.core.evidence import Evidence
from topomap.core.geometry import Pose2
from topomap.core.records import Candidate
from topomap.mapping.closures.voting import Voting, VotingSettings
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


@pytest.mark.parametrize("back", [False, True])
def test_three_that_tell_the_same_shift_are_believed_together(back: bool) -> None:
    voting = Voting(VotingSettings(), road(back))
    pairs = [(query, 39 - query if back else query - 20) for query in (22, 24, 26)]
    turn = math.pi if back else 0.0
    assert voting.add(candidate(*pairs[0], turn)) == ()
    assert voting.add(candidate(*pairs[1], turn)) == ()
    assert [c.query for c in voting.add(candidate(*pairs[2], turn))] == [22, 24, 26]


def test_places_that_hardly_beat_their_rivals_need_more_of_them() -> None:
    voting = Voting(VotingSettings(clear=0.6), road(False))
    found = [voting.add(candidate(20 + k, k, 0.0, ratio=0.8)) for k in range(6)]  # half a vote each
    assert [len(some) for some in found] == [0, 0, 0, 0, 0, 6]


def test_an_active_check_is_a_further_vote() -> None:
    voting = Voting(VotingSettings(), road(False))
    first, second = candidate(22, 2, 0.0), candidate(24, 4, 0.0)
    assert voting.add(first) == ()
    assert voting.add(second) == ()
    voting.drop(first)
    checked = replace(first, evidence=replace(first.evidence, active=1.0))
    assert voting.add(checked) == (second, checked)


def test_what_was_dropped_supports_nothing() -> None:
    voting = Voting(VotingSettings(votes=2), road(False))
    first = candidate(22, 2, 0.0)
    voting.add(first)
    voting.drop(first)
    assert voting.add(candidate(24, 4, 0.0)) == ()


def test_look_alikes_at_random_places_never_agree() -> None:
    voting = Voting(VotingSettings(), road(False))
    for query, match in ((22, 2), (23, 9), (24, 1), (25, 13), (26, 10)):
        assert voting.add(candidate(query, match, 0.0)) == ()


def test_a_wrong_rotation_does_not_agree() -> None:
    voting = Voting(VotingSettings(votes=2), road(False))
    assert voting.add(candidate(22, 2, 0.0)) == ()
    assert voting.add(candidate(23, 3, 0.5)) == ()


def test_what_nothing_supports_in_time_expires_once() -> None:
    voting = Voting(VotingSettings(within=5.0), road(False))
    voting.add(candidate(22, 2, 0.0))
    assert voting.expired(26.0) == ()
    assert [c.query for c in voting.expired(28.0)] == [22]
    assert voting.expired(40.0) == ()
