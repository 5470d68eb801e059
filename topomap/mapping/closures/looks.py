"""Looks: how much likelier what was seen of a place is if the robot is there than if it is elsewhere.

A log likelihood ratio, by how much better the place can be aligned with the view than other places can: than the best
rival, where rivals were compared, or else than places elsewhere usually are. So it adapts: in a row of look-alike
doors the same cost says less than in a hall, and neither the camera nor the aligner's scale matters.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from topomap.mapping.closures.appearance import Outcome

MEMORY = 30  # comparisons over which the usual cost elsewhere is taken
FEWEST = 10  # comparisons before which nothing is usual
MOST = 3.0  # 3 in 100 false ones say as much (office-loop, long-corridor): a single look never says more


class Weights(NamedTuple):
    """A log likelihood ratio by logs of costs: none where all places cost the same, more by each of the two."""

    none: float
    rival: float
    usual: float


# Logistic regressions as `topomap bench looks` makes them, each world's true and false ones counting as much as any
# other's: 791 true and 3168 false ones of room-corridor, hall, office-loop (seeds 0, 1), long-corridor, a1original (0),
# 0 to 0.3 m aside, some with people or at another hour; calibration error 0.04 over all, 0.09 to 0.15 in a world that
# was left out, 0.34 in office-loop.
WITH_RIVALS = Weights(-3.05, 4.74, 10.48)
WITHOUT_RIVALS = Weights(-3.1, 0.0, 13.64)


def log_ratio(weights: Weights, cost: float, rival: float, usual: float) -> float:
    """Return how much likelier a place of this alignment cost is if true, as a log, in [-MOST, MOST].

    rival: the cost of the best place elsewhere; usual: what places elsewhere cost, in the same unit, whatever it is.
    """
    least = 1e-9
    over = [float(np.log(max(other, least) / max(cost, least))) for other in (rival, usual)]
    return float(np.clip(weights.none + weights.rival * over[0] + weights.usual * over[1], -MOST, MOST))


class LogRatio:
    """Tells the log likelihood ratio of what was compared; learns what places elsewhere usually cost."""

    def __init__(self) -> None:
        self._elsewhere: deque[float] = deque(maxlen=MEMORY)

    @property
    def known(self) -> bool:
        """Whether enough places elsewhere were compared to say what they usually cost."""
        return len(self._elsewhere) >= FEWEST

    def of(self, outcome: Outcome, rivals: bool) -> float:
        """Return the log likelihood ratio of a comparison; rivals: whether any place of the map could be one.

        0 where nothing is known: no rival was compared, and what is usual isn't known yet.
        """
        if np.isfinite(outcome.elsewhere):
            self._elsewhere.append(outcome.elsewhere)
        cost = outcome.winner.alignment.residual
        if rivals and outcome.ratio > 0.0:
            return log_ratio(WITH_RIVALS, cost, cost / outcome.ratio, outcome.elsewhere)
        if not self.known:
            return 0.0
        usual = float(np.median(self._elsewhere))
        return log_ratio(WITHOUT_RIVALS, cost, usual, usual)


class UsualCost:
    """What places seen again cost here; it follows the light."""

    def __init__(self) -> None:
        self._costs: deque[float] = deque(maxlen=MEMORY)

    @property
    def value(self) -> float:
        """The median cost; infinite before ten are known."""
        return float(np.median(self._costs)) if len(self._costs) >= FEWEST else np.inf

    def learn(self, cost: float) -> None:
        """Take the cost of a place that won."""
        self._costs.append(cost)
