"""The robot's own tests: what is seen must speak for one place, and for that place itself, not for one near it.

Each refuses or says nothing, as what they look at is the worse for a false closure at one end of its range only; how
much a place that passes looks like the one it is said to be is told by `looks`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.mapping.closures.claims import Claims
from topomap.mapping.closures.closure_tests import ClosureTest, Knowledge
from topomap.mapping.closures.seen import Seen

MOST_COST = 0.8  # alignment cost: 1 for views that share nothing; all of 791 true revisits cost less
MOST_RATIO = 0.9  # to the best rival's cost; of 3168 false ones 8 in 10 are above, of 791 true ones 2 in 10
MOST_TOGETHER = (
    0.95  # ... where others have to agree, each voting by how clearly it wins: 0.3 m beside the first lap of
)
# `office-loop`, by camera alone, true places won time after time with 0.9 to 0.98, wrong ones by turns;
# with these, the votes for a wrong place add up to 0.7, in a warehouse's new aisles to 2, where 3 are asked
MOST_APART = 0.8  # [m] places measured farther apart are two: the false begin at 1 m, ranges err by 0.1 m
TIMES_USUAL = 2.0  # what is at the place costs at most so many times what places seen again usually do
UNMEASURED = 0.25  # [m] error of a position from which on nothing has measured it


def _refused(wrong: BoolArray) -> FloatArray:
    return np.where(wrong, -np.inf, 0.0)


def _seen(knowledge: Knowledge) -> Seen:
    assert knowledge.seen is not None, "these tests are for claims whose places were seen"
    return knowledge.seen


@dataclass(frozen=True, slots=True)
class Alike:
    """Refuses a place that can't be aligned with the view, unless its image alone tells it from all others."""

    most: float = MOST_COST
    name: str = "alike"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return _refused((_seen(knowledge).cost > self.most) & ~_seen(knowledge).clear)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        return f"no place is alike enough (cost {_seen(knowledge).cost[0]:.2f} > {self.most:g})"


@dataclass(frozen=True, slots=True)
class Distinct:
    """Refuses a place that another one is nearly as alike as; less strictly where others have to agree with it."""

    most: float = MOST_RATIO
    together: float = MOST_TOGETHER
    name: str = "distinct"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return _refused(_seen(knowledge).ratio > self._limit(knowledge))

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        ratio, limit = _seen(knowledge).ratio[0], self._limit(knowledge)[0]
        return f"another place is nearly as alike (ratio {ratio:.2f} > {limit:g})"

    def _limit(self, knowledge: Knowledge) -> FloatArray:
        return np.where(_seen(knowledge).waits, self.together, self.most)


@dataclass(frozen=True, slots=True)
class Reachable:
    """Refuses a place at which odometry doesn't allow the robot to be, though it is the most alike of all."""

    name: str = "reachable"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return _refused(~_seen(knowledge).compared)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        return "the place most alike is out of the odometry's reach"


@dataclass(frozen=True, slots=True)
class Familiar:
    """Refuses a place whose image is as unlike the view as other places' images are."""

    name: str = "familiar"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        seen = _seen(knowledge)
        return _refused(seen.difference > seen.limit)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        seen = _seen(knowledge)
        return f"the view is as unlike it as other places are ({seen.difference[0]:.2f} > {seen.limit[0]:.2f})"


@dataclass(frozen=True, slots=True)
class SameSpot:
    """Refuses a place that is measured to lie aside: near a place isn't at it."""

    most: float = MOST_APART
    name: str = "same spot"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        return _refused(np.hypot(claims.relative[:, 0], claims.relative[:, 1]) > self.most)

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        away = float(np.hypot(*claims.relative[0, :2]))
        return f"another place nearby: measured {away:.2f} m apart (at most {self.most:.2f} m)"


@dataclass(frozen=True, slots=True)
class AsUsual:
    """Refuses what is much less alike than places seen again usually are here, where nothing measured how far it is."""

    times: float = TIMES_USUAL
    unmeasured: float = UNMEASURED
    name: str = "as usual"
    lowers: bool = True

    def weigh(self, claims: Claims, knowledge: Knowledge) -> FloatArray:
        """Return 0 or minus infinity (n,)."""
        seen = _seen(knowledge)
        sigma = np.sqrt(np.linalg.eigvalsh(claims.covariance[:, :2, :2])[:, -1])
        return _refused((sigma > self.unmeasured) & (seen.cost > self.times * seen.usual))

    def reason(self, claims: Claims, knowledge: Knowledge) -> str:
        """Say why of one claim."""
        cost, usual = _seen(knowledge).cost[0], _seen(knowledge).usual[0]
        return (
            f"much less alike than places seen again are here (cost {cost:.2f}, usually {usual:.2f}): it is near, "
            "and nothing measures how far"
        )


BY_SIGHT: tuple[ClosureTest, ...] = (Alike(), Distinct(), Reachable(), Familiar())
BY_SPOT: tuple[ClosureTest, ...] = (SameSpot(), AsUsual())
