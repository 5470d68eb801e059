"""Looks: how much likelier what was seen of a place is if the robot is there than if it is elsewhere."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

MOST = 5.0  # beyond it the measurement has too few false ones to tell


class Weights(NamedTuple):
    """A log likelihood ratio by logs of costs: none where all places cost the same, more by each of the two."""

    none: float
    rival: float
    usual: float


# logistic regression over true and false comparisons in several worlds, each world's counting as much as any other's
WITH_RIVALS = Weights(-3.05, 4.74, 10.48)


def log_ratio(weights: Weights, cost: float, rival: float, usual: float) -> float:
    """Return how much likelier a place of this alignment cost is if true, as a log, in [-MOST, MOST].

    rival: the cost of the best place elsewhere; usual: what places elsewhere cost, in the same unit, whatever it is.
    """
    least = 1e-9
    over = [float(np.log(max(other, least) / max(cost, least))) for other in (rival, usual)]
    return float(np.clip(weights.none + weights.rival * over[0] + weights.usual * over[1], -MOST, MOST))
