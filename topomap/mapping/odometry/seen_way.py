"""How far the robot went along a direction that ranges don't tell: both views, before and after, predicted midway."""

from __future__ import annotations

import numpy as np

from topomap.core.arrays import FloatArray
from topomap.core.geometry import Pose2
from topomap.core.panorama import Panorama
from topomap.vision.image.compare import parabola, sector_means
from topomap.vision.image.surroundings import predicted

SPACING = 0.1
"""[m] Between the places that are tried. In 1,580 looks, half a metre apart, along the corridors of six worlds, with
people, noise and by evening too, the likeliest of them was within 0.1 m of the truth in 1,573, and 0.15 m and more off
in five."""
BEYOND, FARTHEST = 0.5, 2.0
"""[m] Farther than anything says, and farthest, that is tried: a view predicted from farther off is none."""
CLEARLY = 1.2
"""Times that the views differ more where the odometry has the robot than elsewhere, before they contradict: with the
odometry off by 0.3 m they do in 99.4 % of those looks, half of them 4 times. A true odometry reaches it in a third of
them, being some centimetres off, which is too little to be untrue; it was 0.15 m off in none."""
EXPLAINED = 0.3
"""Difference up to which what would be seen explains the views: at the likeliest place at most 0.23 in 99 % of those
looks; 0.48 in a round room whose ranges had the turn 6 degrees wrong, and the place then was."""
SECTORS = 15
"""Parts of the view that are compared one by one: people who pass change a third of them, being carried away all."""
MOVED_CLEARLY, MOVED_MOST = 1.5, 0.4
"""Times that a sector differs more by one way than by another, and difference by the other, by which it tells: with 1.2
to 2 times and 0.3 to 0.6, 5 to 16 % of the looks amid people who go along (`company.PARTS`) have fewer than two such
sectors, and at most 0.8 % of those by wheels that spin as many."""


def seen_way(before: Panorama, now: Panorama, pose: Pose2, along: FloatArray, read: float, usual: float) -> float:
    """Return how far [m] the robot went `along` (2,), a unit vector, by the views where they contradict `read` clearly,
    else `read`.

    pose: of `now` seen from `before`, true but along; read: the way along it by the odometry [m]; usual: by what is
    usual. before: with ranges.
    """
    farthest = min(max(read, usual), FARTHEST) + BEYOND
    tried = np.arange(-BEYOND, farthest + SPACING, SPACING)
    aside = pose.array()[:2] - (along @ pose.array()[:2]) * along
    differences = _differences(before, now, pose.heading, aside + np.append(tried, read)[:, np.newaxis] * along)
    *there, claimed = differences
    best = int(np.argmin(there))
    if not 0 < best < len(there) - 1 or there[best] > min(EXPLAINED, claimed / CLEARLY):
        return read
    below, here, above = (np.square(differences[[best + k]]) for k in (-1, 0, 1))
    return float(tried[best] + SPACING * parabola(below, here, above)[0][0])


def _differences(before: Panorama, now: Panorama, turn: float, places: FloatArray) -> FloatArray:
    """Return by how much (D,) the views differ that both predict midway, were the robot at places (D, 2) now: rms,
    median over sectors.

    From half as far a view is predicted well, and what the two get wrong is as wrong ahead of the one as behind the
    other: neither draws the likeliest place near.
    """
    return np.asarray(np.median(_by_sector(before, now, turn, places), axis=1))


def _by_sector(before: Panorama, now: Panorama, turn: float, places: FloatArray) -> FloatArray:
    """Return by how much (D, SECTORS) each sector of the views differs, as `_differences` has it: rms."""
    c, s = np.cos(turn), np.sin(turn)
    back = -places @ np.array([[c, -s], [s, c]])  # from where it is now, looking where it looks now
    views = predicted(now, back / 2)
    spectra = np.fft.rfft(views, axis=2) * np.exp(-1j * turn * np.arange(views.shape[2] // 2 + 1))
    turned = np.fft.irfft(spectra, n=views.shape[2], axis=2)
    squares = np.square(predicted(before, places / 2) - turned).mean(axis=1)
    return np.sqrt(sector_means(squares, SECTORS))


def parts_moved(before: Panorama, now: Panorama, read: Pose2, shown: Pose2) -> int:
    """Return in how many sectors the views are clearly those of a robot that went as it `read`, not as `shown`.

    read, shown: of `now` seen from `before`. before, now: with ranges.
    """
    by_read, by_shown = (
        _by_sector(before, now, pose.heading, pose.array()[np.newaxis, :2])[0] for pose in (read, shown)
    )
    return int(np.sum((by_read < MOVED_MOST) & (by_shown > MOVED_CLEARLY * by_read)))
