"""The row of eye level, found in pairs of views: with the right one, matched points move as a level camera's do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.panorama import Panorama
from topomap.vision.image.keypoints import KeypointSpec, Matches, keypoints, matched_keypoints
from topomap.vision.matching.two_view import EpipolarSpec, movement

ROWS, FINE = 17, 9
"""Rows tried over the image's height, and about the best of them."""
CLEAR = 1.3
"""Agreeing points at the best row over those at the usual one, from which on eye level is found: 2 to 3 in generated
rooms (2 rows off at most), 1.6 in grass (0.3 rows off), 1.03 in photographs of 25 rows, where nothing is."""
WINDOW = math.radians(15.0)  # how far odometry's turn between the two views may be off
POINTS, SEARCH = KeypointSpec(), EpipolarSpec(directions=36, rotations=72, sigmas=(0.03, 0.01), peaks=2)


@dataclass(frozen=True, slots=True)
class EyeLevel:
    """row: of eye level (fractional, may lie outside the image); clear: how much better it is than the usual row."""

    row: float
    clear: float


def eye_level(pairs: Sequence[tuple[Panorama, Panorama, float]]) -> EyeLevel | None:
    """Return the row of eye level by pairs of views (before, after, turn between them [rad]), None where it isn't seen.

    The rig's own horizon_row doesn't matter. A level camera that moves sees a point keep its height over its distance
    from the line of movement; measured from a wrong row, few points do.
    """
    matches = [(_matches(before, after), turn) for before, after, turn in pairs]
    if not matches:
        return None
    rig = pairs[0][0].rig
    coarse = np.linspace(0.0, rig.height - 1.0, ROWS)
    by_pair = _votes(matches, rig.horizon_row, rig.focal, coarse)
    votes, step = by_pair.sum(axis=0), float(coarse[1] - coarse[0])
    halves = [int(by_pair[half::2].sum(axis=0).argmax()) for half in range(2)]
    if abs(halves[0] - halves[1]) > 1:
        return None
    fine = float(coarse[votes.argmax()]) + np.linspace(-step, step, FINE)
    near = _votes(matches, rig.horizon_row, rig.focal, fine).sum(axis=0)
    clear = float(near.max()) / max(float(np.median(votes)), 1e-9)
    return EyeLevel(_peak(fine, near), clear) if clear >= CLEAR and near.max() > 0.0 else None


def _matches(before: Panorama, after: Panorama) -> Matches:
    return matched_keypoints(keypoints(after, POINTS), keypoints(before, POINTS))


def _votes(matches: Sequence[tuple[Matches, float]], horizon_row: float, focal: float, rows: FloatArray) -> FloatArray:
    """Return (P, R) how many points of each pair agree with a level movement, were each row that of eye level."""
    votes = np.zeros((len(matches), len(rows)))
    for k, row in enumerate(rows.tolist()):
        higher = np.array([0.0, 1.0, 0.0, 1.0]) * (row - horizon_row) / focal
        for pair, (found, turn) in enumerate(matches):
            votes[pair, k] = movement(Matches(found.rays + higher, found.weight), turn, WINDOW, SEARCH).points
    return votes


def _peak(rows: FloatArray, votes: FloatArray) -> float:
    """Return the top of the parabola through the best row and its neighbours."""
    k = min(max(int(votes.argmax()), 1), len(rows) - 2)
    below, at, above = votes[k - 1 : k + 2].tolist()
    bend = below - 2.0 * at + above
    offset = 0.5 * (below - above) / bend if bend < 0.0 else 0.0
    return float(rows[k] + min(max(offset, -1.0), 1.0) * (rows[1] - rows[0]))
