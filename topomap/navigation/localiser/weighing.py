"""What looks say: of a hypothesis against the likeliest, of all of them against being elsewhere, and of new places."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.navigation.localiser.likeness import log_ratio
from topomap.navigation.localiser.mixture import Mixture, unseen
from topomap.navigation.localiser.views import Seen

LOOKS = 3
"""Looks that a stretch needs to count: half of what one of 1 m has."""
APART, APART_SHARE = 0.015, 0.1
"""By how much the mean squared likeness of the place itself varies over a stretch, at least and as a share of the least
one: in `office-loop` its most alike rival had 0.036 more in the middle and 0.03 less at worst; 0.007 tells them best,
and twice that allows for errors that last over stretches."""
HARDEST = 5.0
"""What one stretch can say against a hypothesis [nats]: the errors of neighbouring views hang together."""
FIRST = 3.0
"""What the first view can say [nats]: 0.3 m aside in `office-loop`, a wrong place looks more like it in 2 of 5."""
ESCAPE = 1e-3
"""Probability to be carried away unnoticed within a stretch: once in 800 m."""
BORN = np.diag(np.square([0.35, 0.35, math.radians(8.0)]))
"""Covariance of a place found by its view: it is told from its neighbour half a metre off, and to two columns."""


def by_stretch(mixture: Mixture, seen: Seen) -> Mixture:
    """Return the hypotheses weighed by how alike their places looked over the last stretch."""
    return _weighed(mixture, seen, LOOKS, HARDEST)


def by_first_view(mixture: Mixture, seen: Seen) -> Mixture:
    """Return the hypotheses weighed by one look."""
    return _weighed(mixture, seen, 1, FIRST)


def _weighed(mixture: Mixture, seen: Seen, fewest: int, hardest: float) -> Mixture:
    squares, looks, best = mixture.seen.T
    told = looks >= fewest
    ratios = np.zeros(len(squares))
    if told.any():
        mean = squares[told] / looks[told]
        least = mean.min()
        behind = np.minimum((mean - least) / (APART + APART_SHARE * least), hardest)
        # what hides a part of the view is passed within a stretch: whether any place is there, its best look says
        ratios[told] = log_ratio(np.sqrt([best[told].min()]), seen.usual.others) - behind
    return replace(mixture.weighed(ratios, ESCAPE), seen=unseen(len(mixture)))


def with_places(mixture: Mixture, seen: Seen, places: FloatArray) -> Mixture:
    """Return the mixture with the places (N, 3) that look like the view: each, any way round, was as likely before."""
    where, found = seen.minima()
    poses = found.poses(places[where])
    fresh = ~mixture.near(poses).any(axis=1) & (found.likeness < 1.0)
    ratio = np.clip(log_ratio(found.likeness, seen.usual.others), -FIRST, FIRST)
    weights = mixture.elsewhere - math.log(2 * len(places)) + ratio
    return mixture.joined_by(poses[fresh], BORN, weights[fresh]).normalised()
