"""H24, H25: the two points that a step leaves in place, on the ring and over the image (5.1.3.2-5.1.3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from topomap.core.arrays import Float32Array
from topomap.core.errors import ShapeError
from topomap.core.geometry import wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera
from topomap.vision.image.ring import RingSpec, ring
from topomap.vision.matching.image_flow import ROUNDS, GreyView, fitted_image_flow, grey_view
from topomap.vision.matching.ring_flow import FLOW, FlowSpec, fitted_flow

_RING = RingSpec(columns=180)
WEAK = math.radians(0.5)
"""A flow of less than this amplitude [rad] tells no direction."""


@dataclass(frozen=True, slots=True)
class StationaryPoints:
    """Fits f = a sin t + b cos t + c to the ring's horizontal flow; home = atan2(-b, a) + 180 deg; bearing only.

    c is the compass's error, which the fit takes up. spec: the ring; flow: how it is measured.
    """

    origin: ClassVar[Origin] = Origin("H24", "5.1.3.3")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    spec: RingSpec = _RING
    flow: FlowSpec = FLOW

    def describe(self, panorama: Panorama) -> Float32Array:
        """Return the horizon ring (F, C)."""
        return ring(panorama, self.spec)

    def home(self, current: Float32Array, goal: Float32Array) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        if current.shape != goal.shape:
            raise ShapeError(f"rings differ in shape: {current.shape} and {goal.shape}")
        if not current.any() or not goal.any() or current.shape[1] < 5:
            return HomeVector(0.0, None, 0.0)
        found = fitted_flow(current, goal, self.flow)
        sure = min(max(found.strength - WEAK, 0.0) / math.radians(10.0), 1.0)
        return HomeVector(wrap(found.direction + math.pi), None, sure)


@dataclass(frozen=True, slots=True)
class StationaryImage:
    """Fits the flow template of a step to Farnebäck's flow over the whole image, both components; bearing only.

    columns, rows: of the small view; rounds of re-weighting.
    """

    origin: ClassVar[Origin] = Origin("H25", "5.1.3.4; Farnebäck 2003")
    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    columns: int = 360
    rows: int = 50
    rounds: int = ROUNDS

    def describe(self, panorama: Panorama) -> GreyView:
        """Return the small grey view."""
        return grey_view(panorama, self.columns, self.rows)

    def home(self, current: GreyView, goal: GreyView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if not current.tells or not goal.tells:
            return HomeVector(0.0, None, 0.0)
        found, trust = fitted_image_flow(current, goal, self.rounds)
        sure = min(max(found.strength - WEAK, 0.0) / math.radians(6.0), 1.0) * trust
        return HomeVector(wrap(found.direction + math.pi), None, sure)
