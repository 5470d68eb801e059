"""H24, H25: the two points that a step leaves in place, on the ring and over the image (5.1.3.2-5.1.3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, TypeVar, cast

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.errors import ShapeError
from topomap.core.geometry import TAU, wrap
from topomap.core.panorama import Panorama
from topomap.core.records import HomeVector
from topomap.core.rig import Rig
from topomap.vision.contracts import Needs, Origin
from topomap.vision.homing.view_vector import same_camera
from topomap.vision.image.compare import normalised, shrunk
from topomap.vision.image.ring import RingSpec, ring
from topomap.vision.matching.ring_flow import FLOW, FlowSpec, fitted_flow, measured_flow

_RING = RingSpec(columns=180)
P = TypeVar("P", Image, Float32Array)
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


@dataclass(frozen=True, slots=True, eq=False)
class GreyView:
    """A small grey view (R, C) uint8 and the camera that saw it."""

    picture: Image
    rig: Rig


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
    rounds: int = 8

    def describe(self, panorama: Panorama) -> GreyView:
        """Return the small grey view."""
        small = np.rint(shrunk(panorama, self.columns, self.rows)).astype(np.uint8)
        return GreyView(small, panorama.rig)

    def home(self, current: GreyView, goal: GreyView) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame. Raises ShapeError."""
        same_camera(current.rig, goal.rig)
        if min(current.picture.std(), goal.picture.std()) < 1e-3 or min(goal.picture.shape) < 5:
            return HomeVector(0.0, None, 0.0)
        flow = around_flow(goal.picture, current.picture)
        fit, trust = self._fitted(flow, goal)
        strength = math.hypot(fit[0], fit[1])
        sure = min(max(strength - WEAK, 0.0) / math.radians(6.0), 1.0) * trust
        return HomeVector(wrap(math.atan2(-fit[1], fit[0]) + math.pi), None, sure)

    def _fitted(self, flow: FloatArray, goal: GreyView) -> tuple[FloatArray, float]:
        """Fit a sin t + b cos t + c and v (a cos t - b sin t) to the flow; return a, b, c and the share that fits."""
        rows, columns = goal.picture.shape
        t = np.arange(columns) * (TAU / columns) + 0.5 * (TAU / columns - TAU / goal.rig.width)
        row = (np.arange(rows) + 0.5) * goal.rig.height / rows - 0.5
        v = np.repeat((goal.rig.horizon_row - row) / goal.rig.focal, columns)
        sin, cos = np.tile(np.sin(t), rows), np.tile(np.cos(t), rows)
        one, zero = np.ones_like(v), np.zeros_like(v)
        design = np.concatenate([np.stack([sin, cos, one], 1), np.stack([v * cos, -v * sin, zero], 1)])
        sideways = flow[:, :, 0].ravel() * (TAU / columns)
        upward = -flow[:, :, 1].ravel() * (goal.rig.height / rows / goal.rig.focal)
        wanted = np.concatenate([sideways, upward])
        slope = np.abs(np.roll(goal.picture, -1, 1).astype(np.float64) - np.roll(goal.picture, 1, 1)).ravel()
        rise = np.abs(np.gradient(goal.picture.astype(np.float64), axis=0)).ravel()
        return _robust(design, wanted, np.concatenate([slope, 2.0 * rise]), self.rounds)


def _robust(design: FloatArray, wanted: FloatArray, texture: FloatArray, rounds: int) -> tuple[FloatArray, float]:
    weight = texture / (texture + 10.0)
    trust = np.ones_like(wanted)
    fit: FloatArray = np.zeros(3)
    scale = math.radians(15.0)
    for _ in range(rounds):
        weighted = design * (weight * trust)[:, np.newaxis]
        fit = np.asarray(np.linalg.solve(weighted.T @ design + 1e-9 * np.eye(3), weighted.T @ wanted), np.float64)
        scale = max(0.7 * scale, math.radians(2.0))
        trust = 1.0 / np.square(1.0 + np.square((wanted - design @ fit) / scale))
    return fit, float(np.sum(weight * trust) / max(np.sum(weight), 1e-9))


def around_flow(goal: Image, current: Image) -> FloatArray:
    """Return Farnebäck's (2003) dense flow goal -> current (R, C, 2) [pixels], computed across the seam.

    A view this low allows no image pyramid: the ring's block matching gives the large movements to start from.
    """
    columns = goal.shape[1]
    coarse = measured_flow(_bands(current), _bands(goal), FLOW)[0] * (columns / TAU)
    start = np.zeros((*goal.shape, 2), np.float32)
    start[:, :, 0] = cv2.medianBlur(_around(coarse[np.newaxis].astype(np.float32), 8), 5)[:, 8:-8]
    pad = columns // 8
    wide = [_around(p, pad) for p in (goal, current)]
    flags = cv2.OPTFLOW_USE_INITIAL_FLOW
    flow = cv2.calcOpticalFlowFarneback(wide[0], wide[1], _around(start, pad), 0.5, 1, 15, 4, 7, 1.5, flags)
    return np.asarray(flow[:, pad : pad + columns], np.float64)


def _around(picture: P, pad: int) -> P:
    return cast(P, np.concatenate([picture[:, -pad:], picture, picture[:, :pad]], axis=1))


def _bands(picture: Image) -> Float32Array:
    middle = picture[len(picture) // 4 : max(3 * len(picture) // 4, 1)].astype(np.float32)
    return normalised(np.asarray(cv2.resize(middle, (picture.shape[1], 5), interpolation=cv2.INTER_AREA), np.float32))
