"""The robot's own tests: each refuses on its side of its limit, says why, and lets the rest pass."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest

from topomap.core.geometry import Pose2
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import ClosureTest, Explains, Knowledge
from topomap.mapping.closures.engine import ClosureEngine
from topomap.mapping.closures.looks import UsualCost
from topomap.mapping.closures.seen import Seen
from topomap.mapping.closures.sight_tests import (
    BY_SIGHT,
    BY_SPOT,
    Alike,
    AsUsual,
    Distinct,
    Familiar,
    Reachable,
    SameSpot,
)

UNMEASURED, MEASURED = np.diag([0.35, 0.03, 0.05]) ** 2, np.diag([0.04, 0.03, 0.02]) ** 2


def seen(
    difference: float = 0.3,
    limit: float = 0.9,
    cost: float = 0.4,
    ratio: float = 0.6,
    usual: float = 0.3,
    compared: bool = True,
    waits: bool = False,
) -> Seen:
    return Seen.of_one(difference, limit, cost, ratio, usual, compared, waits=waits)


def said(
    test: ClosureTest, what: Seen, covariance: np.ndarray = MEASURED, away: tuple[float, float] = (0.0, 0.0)
) -> str:
    """What a test says against a claim, "" where it lets it pass."""
    claim = Claims.of_one(0, 1, Pose2(*away, 1.5), covariance)
    knowledge = Knowledge.of_one(np.zeros((2, 3)), np.zeros((3, 3)), what)
    found = test.weigh(claim, knowledge)
    assert found.shape == (1,)
    assert found[0] in (0.0, -np.inf)
    return "" if found[0] == 0.0 else cast(Explains, test).reason(claim, knowledge)


@pytest.mark.parametrize(
    ("test", "passes", "fails", "reason"),
    [
        (Alike(), seen(cost=0.79), seen(cost=0.81), "no place is alike enough (cost 0.81 > 0.8)"),
        (Distinct(), seen(ratio=0.89), seen(ratio=0.91), "another place is nearly as alike (ratio 0.91 > 0.9)"),
        (
            Distinct(), seen(ratio=0.94, waits=True), seen(ratio=0.96, waits=True),
            "another place is nearly as alike (ratio 0.96 > 0.95)",
        ),
        (Reachable(), seen(), seen(compared=False), "the place most alike is out of the odometry's reach"),
        (
            Familiar(), seen(difference=0.89), seen(difference=0.91),
            "the view is as unlike it as other places are (0.91 > 0.90)",
        ),
    ],
)  # fmt: skip
def test_by_sight(test: ClosureTest, passes: Seen, fails: Seen, reason: str) -> None:
    assert said(test, passes) == ""
    assert said(test, fails) == reason


def test_a_place_measured_a_metre_off_is_another_one() -> None:
    assert "0.94 m apart" in said(SameSpot(), seen(), away=(-0.5, 0.8))
    assert said(SameSpot(), seen(), away=(0.0, 0.79)) == ""
    assert said(SameSpot(), seen(), away=(0.0, 0.81))


def test_a_view_much_less_alike_than_usual_is_near_the_place_only() -> None:
    assert said(AsUsual(), seen(cost=0.61, usual=np.inf), UNMEASURED) == ""  # nothing is usual yet
    assert "(cost 0.61, usually 0.30)" in said(AsUsual(), seen(cost=0.61), UNMEASURED)
    assert said(AsUsual(), seen(cost=0.59), UNMEASURED) == ""
    assert said(AsUsual(), seen(cost=0.61), MEASURED) == ""


def test_what_is_usual_is_known_after_ten_and_follows_the_light() -> None:
    usual = UsualCost()
    for _ in range(9):
        usual.learn(0.2)
    assert usual.value == np.inf
    usual.learn(0.2)
    assert usual.value == 0.2
    for _ in range(30):
        usual.learn(0.6)
    assert usual.value == 0.6


def test_the_engine_names_the_first_test_that_refuses() -> None:
    engine = ClosureEngine((*BY_SIGHT, *BY_SPOT))
    claim = Claims.of_one(0, 1, Pose2(0.9, 0.0, 0.0), MEASURED)
    knowledge = Knowledge.of_one(np.zeros((2, 3)), np.zeros((3, 3)), seen(ratio=0.95))
    failed = int(engine.weigh(claim, knowledge, -np.inf).failed[0])
    assert engine.reason(claim, knowledge, failed).startswith("another place is nearly as alike")
    later = int(engine.weigh(claim, knowledge, -np.inf, slice(len(BY_SIGHT), None)).failed[0])
    assert engine.reason(claim, knowledge, later).startswith("another place nearby")


def test_some_of_what_was_seen_is_theirs() -> None:
    flags = (np.array([True, False]), np.array([False, True]), np.array([True, False]))
    both = Seen(*(np.array([k, k + 10.0]) for k in range(5)), *flags)
    part = both.among(np.array([1]))
    assert [part.difference[0], part.limit[0], part.cost[0], part.ratio[0], part.usual[0]] == [10, 11, 12, 13, 14]
    assert not part.compared[0]
