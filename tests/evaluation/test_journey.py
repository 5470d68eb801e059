"""The way home in numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic_run import LAP, make_run

from topomap.core.run_data import Leg
from topomap.evaluation.journey import HomeResult, handover_step, home, legs, reference_route

RUN = make_run()


def test_claimed_and_not_within_is_told_apart() -> None:
    result = home(RUN)
    # 60 steps after hand-over at the start, the goal is node 7, taken at step 56
    assert result.asked
    assert result.claimed
    assert not result.within
    assert result.error == pytest.approx(0.4, abs=0.01)
    assert result.path_ratio is None, "a way that didn't lead home has no ratio"


def test_within_thirty_centimetres() -> None:
    nearer = replace(RUN, nodes=tuple(replace(n, stamp_ns=n.stamp_ns + 10**9) for n in RUN.nodes))
    result = home(nearer)
    assert result.within
    assert result.error == pytest.approx(0.0, abs=1e-9)
    assert result.path_ratio == pytest.approx(1.0, rel=0.02)
    assert home(replace(nearer, claimed=False)).path_ratio is None


def test_only_contact_after_handover_is_a_collision() -> None:
    contact = np.zeros(len(RUN.stamps_ns), dtype=np.bool_)
    contact[[5, 2 * LAP - 1, 2 * LAP, 2 * LAP + 9, 2 * LAP + 10, 2 * LAP + 20]] = True
    # the episode that the driver began isn't the stack's
    assert home(replace(RUN, contact=contact)).collisions == 2


def test_the_reference_follows_the_milestones() -> None:
    assert handover_step(RUN) == 2 * LAP
    route = reference_route(RUN)
    assert route is not None
    assert len(route) == 5
    straight = reference_route(replace(RUN, milestones=()))
    assert straight is not None
    assert len(straight) == 2
    assert RUN.truth is not None
    assert straight[1] == pytest.approx(RUN.truth[56, :2])


def test_a_replay_and_a_run_without_a_goal() -> None:
    assert home(replace(RUN, replayed=True)) == HomeResult()
    assert home(replace(RUN, goal_node=None)) == HomeResult(asked=False)


def test_driven_to_the_end_has_no_way_home() -> None:
    result = home(replace(RUN, driven=np.ones(len(RUN.stamps_ns), dtype=np.bool_)))
    assert result.path_ratio is None
    assert result.collisions is None


def test_each_leg_is_judged_where_it_ended() -> None:
    assert RUN.truth is not None
    # taken at step 2 * LAP + 24, so that the leg up to there led to it
    there = replace(RUN.nodes[3], stamp_ns=int(RUN.stamps_ns[2 * LAP + 24]))
    nodes = (*RUN.nodes[:3], there, *RUN.nodes[4:])
    contact = np.isin(np.arange(len(RUN.stamps_ns)), [2 * LAP + 3, 2 * LAP + 30])
    ways = (
        Leg(3, 2 * LAP, 2 * LAP + 24, True),
        Leg(3, 2 * LAP + 25, 2 * LAP + 40, True),
        Leg(99, 2 * LAP + 41, 2 * LAP + 44, None),
    )
    first, second, third = legs(replace(RUN, nodes=nodes, contact=contact, legs=ways))
    assert (first.within, first.error, first.collisions) == (True, pytest.approx(0.0, abs=1e-9), 1)
    assert first.ratio is not None
    assert 1.0 <= first.ratio < 1.2
    assert (second.claimed, second.within, second.ratio, second.collisions) == (True, False, None, 1)
    assert (third.claimed, third.within, third.error, third.collisions) == (None, None, None, 0)
    assert third.way is not None
    assert third.way > 0.0


def test_legs_of_a_replay_and_of_a_drive_whose_truth_nobody_knows() -> None:
    ways = (Leg(7, 2 * LAP, 2 * LAP + 24, True),)
    assert legs(replace(RUN, legs=ways, replayed=True)) == []
    (only,) = legs(replace(RUN, legs=ways, truth=None, contact=None))
    assert (only.claimed, only.within, only.error, only.way, only.ratio, only.collisions) == (True,) + (None,) * 5


def test_of_a_patrol_home_is_the_last_leg() -> None:
    first, last = Leg(3, 2 * LAP, 2 * LAP + 24, True), Leg(7, 2 * LAP + 25, len(RUN.stamps_ns) - 1, True)
    whole = replace(RUN, contact=np.isin(np.arange(len(RUN.stamps_ns)), [2 * LAP + 3, 2 * LAP + 30]))
    assert home(whole).collisions == 2
    assert home(replace(whole, legs=(last,))).collisions == 2
    assert home(replace(whole, legs=(first, last))).collisions == 1
