"""Where a robot that was carried may be, by its first view of where it is now."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from topomap.core.arrays import FloatArray, IntArray
from topomap.navigation.localiser.likeness import log_ratio
from topomap.navigation.localiser.mixture import Mixture, same
from topomap.navigation.localiser.views import Seen
from topomap.navigation.localiser.weighing import BORN, GROWTH, units_behind

SLOPE = 1.0
"""[nats] What the first view says against a place for every unit by which it is less like it than the most alike one.
Of robots set down in seven worlds, 708 as they were taught and 150 when it had become evening, 1 to 2 tell best, where
the most alike place was right in .6 to .9 of cases and where in 0 to .4; with 1 those that were said to be right in .8
and more were wrong no oftener than said, with 2 three times as often."""
OTHERWISE = 0.02
"""Probability that the place doesn't look as it did, so that it may be any: 8 of 708 were more than 3 units
behind."""
UNMAPPED = 0.2
"""Probability, before anything is seen, that a robot was carried to where the map has no places. Views of other worlds
are at least 0.65 of what is usual off the most alike place, those of the map 0.1 to 0.25."""
ODDS = UNMAPPED / (1.0 - UNMAPPED)
"""Of being off the map."""


def set_down(mixture: Mixture, seen: Seen, places: FloatArray) -> Mixture:
    """Return the mixture after the whole map, places (N, 3), was looked through: what was elsewhere is at one of the
    places like the view, at one that looks like them and isn't on the map, off the map, or where it looks otherwise.
    """
    where, found = seen.minima()
    poses = found.poses(places[where])
    fresh = ~mixture.near(poses).any(axis=1) & (found.likeness < 1.0)
    if not fresh.any():
        return mixture
    poses, squares = poses[fresh], np.square(found.likeness[fresh])
    behind = units_behind(squares)
    tops = _tops(poses, behind)
    likely = np.exp(-SLOPE * behind[tops])
    rivals = likely.sum() - likely.max()
    here = likely / (likely.sum() + ODDS * rivals)  # as many that look like these may not be on the map
    known = (1.0 - OTHERWISE) * _on_map(seen, float(np.sqrt(squares.min())))
    weights = mixture.elsewhere + np.log(np.maximum(here * known, 1e-12))
    said = np.sqrt(SLOPE * behind[tops] / GROWTH)  # a stretch that says the same says no more
    rest = mixture.elsewhere + math.log1p(-known * float(here.sum()))
    return replace(mixture.joined_by(poses[tops], BORN, weights, said), elsewhere=rest).normalised()


def _tops(poses: FloatArray, behind: FloatArray) -> IntArray:
    """Return the numbers of the poses (n, 3) that no more alike one lies near."""
    order = np.argsort(behind, kind="stable")
    alike = same(poses[order], poses[order])
    left, tops = np.ones(len(order), bool), list[int]()
    for k in range(len(order)):
        if left[k]:
            tops.append(int(order[k]))
            left &= ~alike[k]
    return np.array(tops, np.int64)


def _on_map(seen: Seen, likeness: float) -> float:
    """Return the probability that the robot is on the map at all, where so much is like one of its places."""
    ratio = float(log_ratio(np.array([likeness]), seen.usual.others)[0])
    return 1.0 / (1.0 + ODDS * math.exp(-ratio))
