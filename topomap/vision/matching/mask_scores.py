"""The thesis's own score of matched masks: the inverse of the outputs' difference, level by level (4.1.1.4)."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import BoolArray, FloatArray
from topomap.core.geometry import wrap_all
from topomap.vision.image.landmarks import Landmarks, Pairs

FLOOR = 0.05
"""Added to a difference, in standard deviations of the view: equal outputs score 20, not infinity."""


def inverse_scores(current: Landmarks, goal: Landmarks, reach: float, levels: int) -> FloatArray:
    """Return the scores (N goal, M current): sum over levels of 1 / difference, 0 beyond `reach` [rad] of bearing."""
    shape = (len(goal), len(current), levels, -1)
    apart = np.square(goal.looks[:, np.newaxis] - current.looks[np.newaxis]).reshape(shape)
    scores = (1.0 / (np.sqrt(apart.mean(axis=3)) + FLOOR)).sum(axis=2)
    moved = np.abs(wrap_all(goal.bearings[:, np.newaxis] - current.bearings[np.newaxis]))
    return np.asarray(np.where(moved <= reach, scores, 0.0), np.float64)


def best_partners(current: Landmarks, goal: Landmarks, reach: float, levels: int) -> Pairs:
    """Return every goal mask with the current mask of the highest score, weighted by it."""
    if not len(current) or not len(goal):
        nothing = np.empty(0, np.intp)
        return Pairs(nothing, nothing, np.empty(0))
    scores = inverse_scores(current, goal, reach, levels)
    partner = scores.argmax(axis=1)
    best = scores[np.arange(len(goal)), partner]
    found = best > 0.0
    return Pairs(partner[found], np.flatnonzero(found), best[found])


def unambiguous(
    current: Landmarks, goal: Landmarks, pairs: Pairs, reach: float, levels: int, ambiguity: float
) -> BoolArray:
    """Return which pairs (M,) have no rival on either side that scores within `ambiguity` of them; both ends of an
    ambiguous connection go (4.7).
    """
    if not len(pairs.weight):
        return np.empty(0, np.bool_)
    rivals = inverse_scores(current, goal, reach, levels)
    rivals[pairs.goal, pairs.current] = 0.0
    rival = np.maximum(rivals[pairs.goal].max(axis=1), rivals[:, pairs.current].max(axis=0))
    mutual = np.array([np.count_nonzero(pairs.current == c) == 1 for c in pairs.current])
    clear: BoolArray = mutual & (rival < (1.0 - ambiguity) * pairs.weight)
    return clear
