"""The automatic choice: which method answers depends on what is there, and every answer says how sure it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from topomap.core.panorama import Panorama
from topomap.core.records import Alignment, HomeVector
from topomap.vision.aligned_homing import Turned
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.dtw import DynamicWarping
from topomap.vision.homing.epipolar import Epipolar, home_of
from topomap.vision.homing.scan import NEAR_PRIOR, ScanMatching
from topomap.vision.homing.view_vector import same_views
from topomap.vision.image.aligned_difference import aligned_difference
from topomap.vision.image.scale_planes import WARPING, WarpingSpec, warping_view
from topomap.vision.matching.warping import best, warp

Choice = Literal["epipolar", "range", "dtw", "warping", "none"]
CHANCE = -1.1
"""Log odds of being within 45 deg without any evidence: a quarter of all directions is."""
CALIBRATION: dict[Choice, float] = {"epipolar": 2.76, "range": 5.15, "dtw": 7.35, "warping": 10.74}
"""Slope of the logistic P(error < 45 deg) over each choice's own evidence (tests/vision/calibration.py)."""
DTW, EPIPOLAR, NEAR = DynamicWarping(), Epipolar(), ScanMatching()
DOUBTFUL, CLEARLY = 0.4, 1.5
"""A fit of fewer rays is doubted, and another rotation believed that fits so much better: the right one fits 0.2 of a
hall's rays behind pillars, 0.5 in a room; turned rooms fit nearly as well, so that the images decide between them.
"""


@dataclass(frozen=True, slots=True)
class Answer:
    """What answered: choice, its evidence (the larger the surer), the alignment with the home vector."""

    choice: Choice
    evidence: float
    alignment: Alignment


@dataclass(frozen=True, slots=True)
class Auto:
    """Matched points where enough of them agree; else, after A6, the scans where there are ranges, DTW near the goal
    (aligned image difference below `near`), min-warping far from it; own compass.

    keypoints False: without matched points, which take most of the time. The distance is the scans' where there are
    ranges. The confidence is P(error < 45 deg), calibrated on
    generated rooms; 0 at the goal itself and where there is nothing to see. points: how many agreeing points are
    enough; window [rad]: how far the views may be turned against each other, or from a prior.
    """

    origin: ClassVar[Origin] = Origin("own", "picks by what is there")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    keypoints: bool = True
    near: float = 0.6
    points: float = 6.0
    window: float = math.pi
    spec: WarpingSpec = WARPING

    def describe(self, panorama: Panorama) -> Panorama:
        """Return the panorama, which keeps what was derived from it."""
        return panorama

    def home(self, current: Panorama, goal: Panorama) -> HomeVector:
        """Return the bearing [rad] of the goal in the current robot's frame. Raises ShapeError."""
        return self.align(current, goal, 0.0 if self.window < math.pi else None).home or HomeVector(0.0, None, 0.0)

    def align(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Alignment:
        """Return the rotation [rad] with the home vector: the method is an `Aligner` as well. Raises ShapeError."""
        return self.answer(current, goal, prior).alignment

    def answer(self, current: Panorama, goal: Panorama, prior: float | None = None) -> Answer:
        """Return the answer with what gave it. Raises ShapeError."""
        same_views(current, goal)
        return (self._pointed(current, goal, prior) if self.keypoints else None) or self._turned(current, goal, prior)

    def _pointed(self, current: Panorama, goal: Panorama, prior: float | None) -> Answer | None:
        """Answer by matched points where enough of them agree."""
        found = EPIPOLAR.movement(
            EPIPOLAR.describe(current), EPIPOLAR.describe(goal), prior, min(self.window, NEAR_PRIOR)
        )
        agreed = found.points * found.contrast
        if agreed < self.points:
            return None
        aligned = Alignment(found.rotation, 1.0 - found.support, home_of(found))
        return self._sure("epipolar", math.log(agreed), aligned, current, goal)

    def _turned(self, current: Panorama, goal: Panorama, prior: float | None) -> Answer:
        """Answer by the rotation of min-warping and what fits best then."""
        here, there = warping_view(current, self.spec), warping_view(goal, self.spec)
        turned = best(warp(here, there, prior, min(self.window, NEAR_PRIOR)))
        if turned.home is None or turned.home.confidence <= 0.0:
            nothing = Alignment(turned.rotation, turned.residual, HomeVector(0.0, None, 0.0))
            return Answer("none", 0.0, nothing)
        scanned = self._scanned(current, goal, prior, turned.rotation)
        if scanned is not None:
            # scans of alike rooms lie well on one another: only the images tell whether it is this place at all
            return self._sure("range", max(1.0 - turned.residual, 0.0), scanned, current, goal)
        return self._warped(turned, turned.home, current, goal)

    def _scanned(self, current: Panorama, goal: Panorama, prior: float | None, rotation: float) -> Alignment | None:
        """Return where the scans fit best, turned as the images say or, where that fits far worse, anyhow."""
        near = NEAR.align(current, goal, rotation)
        anyhow = near
        if 1.0 - near.residual < DOUBTFUL:
            anyhow = replace(NEAR, window=self.window).align(current, goal, prior)
        found = anyhow if 1.0 - anyhow.residual > CLEARLY * (1.0 - near.residual) else near
        return found if found.home is not None and found.home.confidence > 0.0 else None

    def _warped(self, turned: Alignment, home: HomeVector, current: Panorama, goal: Panorama) -> Answer:
        aligned = Turned.of(current, turned.rotation)
        match = DTW.match(DTW.describe(aligned.view), DTW.describe(goal))
        matched = aligned.back(match.home)
        # two methods that go wrong in different ways: where they agree, both are likely right
        agreement = 0.5 + 0.5 * math.cos(matched.bearing - home.bearing)
        if aligned_difference(current, goal, turned.rotation) < self.near:
            return self._sure("dtw", (1.0 - match.cost) * agreement, replace(turned, home=matched), current, goal)
        return self._sure("warping", home.confidence * agreement, turned, current, goal)

    def _sure(self, choice: Choice, evidence: float, found: Alignment, current: Panorama, goal: Panorama) -> Answer:
        home = found.home or HomeVector(0.0, None, 0.0)
        odds = CHANCE + CALIBRATION[choice] * evidence
        sure = 1.0 / (1.0 + math.exp(-min(max(odds, -30.0), 30.0))) if home.confidence > 0.0 else 0.0
        distance = home.distance if home.distance is not None else _distance(current, goal, found.rotation)
        return Answer(
            choice, evidence, Alignment(found.rotation, found.residual, HomeVector(home.bearing, distance, sure))
        )


def _distance(current: Panorama, goal: Panorama, rotation: float) -> float | None:
    """Return how far the goal lies off [m], where both views have ranges."""
    found = NEAR.align(current, goal, rotation).home
    return found.distance if found is not None and found.confidence > 0.0 else None
