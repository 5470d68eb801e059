"""What looks say: of a hypothesis against the likeliest, of all of them against being elsewhere, and of new places."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
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
GROWTH = 1.0
"""How a stretch speaks against a hypothesis by how far it is behind the most alike one, in units of what varies: as the
square. Between two corridors alike the place itself was the worse one by 0.2 to 0.4 units in 16 of 35 stretches, by 0.4
to 0.7 in 10 of 37, by 0.7 to 1 in 4 of 24, by 1 to 1.5 in 3 of 59; in `office-loop` by all of these less often. That is
1.8 for one stretch alone; of a search's five or so the most counts, and with 1.8 one of 20 ended sure and wrong."""
LASTING = 0.95
"""Share of the most that was said against a hypothesis that the next stretch has to exceed to say more. What differs a
little between two places alike hangs together from stretch to stretch (by 0.85 between two corridors, by 0.6 in
`office-loop`): it is how far aside the robot drives and in what light."""
HIDDEN = 2.0
"""What a stretch whose view is hidden in part says for being where the rest of it is as it was [nats]: 2.8 by the
shares in `hidden`, were neighbouring looks independent."""
FIRST = 3.0
"""What the first view can say [nats]: 0.3 m aside in `office-loop`, a wrong place looks more like it in 2 of 5."""
ESCAPE = 1e-3
"""Probability to be carried away unnoticed within a stretch: once in 800 m."""
BORN = np.diag(np.square([0.35, 0.35, math.radians(8.0)]))
"""Covariance of a place found by its view: it is told from its neighbour half a metre off, and to two columns."""


def by_stretch(mixture: Mixture, seen: Seen, hidden: bool = False) -> Mixture:
    """Return the hypotheses weighed by how alike their places looked over the last stretch.

    hidden: the view is hidden in part, and as it was at the likeliest place in the rest of it.
    """
    told, behind = _behind(mixture, LOOKS)
    said = LASTING * mixture.behind[told]
    most = mixture.behind.copy()
    most[told] = np.maximum(behind, said)
    return replace(_weighed(mixture, seen, told, _spoken(behind, said), hidden), behind=most)


def against(squares: FloatArray, least: float) -> FloatArray:
    """Return what a stretch of such mean squared likenesses (n,) says against places, of which the most alike has
    `least` [nats].
    """
    return _spoken(np.maximum(squares - least, 0.0) / (APART + APART_SHARE * least), np.zeros(len(squares)))


def _spoken(behind: FloatArray, said: FloatArray) -> FloatArray:
    spoken: FloatArray = np.minimum(GROWTH * np.maximum(np.square(behind) - np.square(said), 0.0), HARDEST)
    return spoken


def by_first_view(mixture: Mixture, seen: Seen) -> Mixture:
    """Return the hypotheses weighed by one look."""
    told, behind = _behind(mixture, 1)
    return _weighed(mixture, seen, told, np.minimum(behind, FIRST))


def _behind(mixture: Mixture, fewest: int) -> tuple[BoolArray, FloatArray]:
    """Return which hypotheses (n,) had so many looks, and how far these are behind the most alike one (k,)."""
    squares, looks, _ = mixture.seen.T
    told = looks >= fewest
    mean = squares[told] / looks[told]
    return told, units_behind(mean)


def units_behind(squares: FloatArray) -> FloatArray:
    """Return how far squared likenesses (n,) are behind the least one, in units of what varies at the place itself."""
    least = squares.min(initial=np.inf)
    behind: FloatArray = (squares - least) / (APART + APART_SHARE * least)
    return behind


def _weighed(mixture: Mixture, seen: Seen, told: BoolArray, against: FloatArray, hidden: bool = False) -> Mixture:
    """Return the hypotheses weighed by what speaks against those told of, and by whether any place is there at all."""
    ratios = np.zeros(len(mixture))
    if told.any():
        # what hides a part of the view is passed within a stretch: whether any place is there, its best look says
        best = np.sqrt([mixture.seen[told, 2].min()])
        there = log_ratio(best, seen.usual.others)
        ratios[told] = (np.maximum(there, HIDDEN) if hidden else there) - against
    return replace(mixture.weighed(ratios, ESCAPE), seen=unseen(len(mixture)))


def with_places(mixture: Mixture, seen: Seen, places: FloatArray) -> Mixture:
    """Return the mixture with the places (N, 3) that look like the view: each, any way round, was as likely before."""
    where, found = seen.minima()
    poses = found.poses(places[where])
    fresh = ~mixture.near(poses).any(axis=1) & (found.likeness < 1.0)
    ratio = np.clip(log_ratio(found.likeness, seen.usual.others), -FIRST, FIRST)
    weights = mixture.elsewhere - math.log(2 * len(places)) + ratio
    return mixture.joined_by(poses[fresh], BORN, weights[fresh]).normalised()
