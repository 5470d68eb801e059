"""Planar epipolar homing: beyond the thesis, the method that beats its best row where there is texture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera
from topomap.vision.image.keypoints import Keypoints, KeypointSpec, keypoints, matched_keypoints
from topomap.vision.matching.two_view import EpipolarSpec, Movement, movement

KEYPOINTS = KeypointSpec()
SEARCH = EpipolarSpec()
ENOUGH = 8.0
"""Points that agree on a movement before it is believed by half."""


@dataclass(frozen=True, slots=True)
class Epipolar:
    """The direction of movement that most matched points allow, reversed (`topomap.vision.matching.two_view`).

    No distances are assumed equal, no compass is needed; window [rad]: how far the views may be turned against
    each other. Bearing only.
    """

    origin: ClassVar[Origin] = Origin("own", "planar epipolar geometry; Ortín, Montiel 2001")
    needs: ClassVar[Needs] = Needs()
    claims_homing: ClassVar[bool] = True
    spec: KeypointSpec = KEYPOINTS
    search: EpipolarSpec = SEARCH
    window: float = math.pi

    def describe(self, panorama: Panorama) -> Keypoints:
        """Return the view's feature points."""
        return keypoints(panorama, self.spec)

    def home(self, current: Keypoints, goal: Keypoints) -> HomeVector:
        """Return the bearing [rad] of the goal in the current robot's frame. Raises ShapeError."""
        return home_of(self.movement(current, goal, 0.0, self.window))

    def movement(self, current: Keypoints, goal: Keypoints, prior: float | None, window: float) -> Movement:
        """Return direction and rotation of the movement goal -> current. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        return movement(matched_keypoints(current, goal), prior, window, self.search)


def home_of(found: Movement) -> HomeVector:
    """Return the way back in the current robot's frame; the confidence grows with votes and contrast."""
    agreed = found.points * found.contrast
    sure = agreed**2 / (agreed**2 + ENOUGH**2) if found.contrast > 0.02 else 0.0
    return HomeVector(wrap(found.direction + math.pi - found.rotation), None, sure)
