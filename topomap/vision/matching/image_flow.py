"""Stationary points over the whole image (5.1.3.4): a step's flow template fitted to Farnebäck's dense flow."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeVar, cast

import cv2
import numpy as np

from topomap.core.arrays import Float32Array, FloatArray, Image
from topomap.core.geometry import TAU
from topomap.core.panorama import Panorama
from topomap.core.rig import Rig
from topomap.vision.image.compare import normalised, shrunk
from topomap.vision.matching.ring_flow import FLOW, Flow, measured_flow

P = TypeVar("P", Image, Float32Array)
ROUNDS = 8
FEWEST, SEAM = 5, 8
"""Rows from which on there is a flow; columns taken from beyond the seam, so that a narrower view has none."""


@dataclass(frozen=True, slots=True, eq=False)
class GreyView:
    """A small grey view (R, C) uint8 and the camera that saw it."""

    picture: Image
    rig: Rig

    @property
    def tells(self) -> bool:
        """Whether there is anything to see, in enough rows and columns for a flow."""
        rows, columns = self.picture.shape
        return bool(self.picture.std() >= 1e-3 and rows >= FEWEST and columns >= SEAM)

    def rolled(self, turn: float) -> GreyView:
        """Return the view rolled by the nearest column to an angle [rad], as `Panorama.rotated` rolls."""
        return replace(self, picture=np.roll(self.picture, round(turn * self.picture.shape[1] / TAU), axis=1))


def grey_view(panorama: Panorama, columns: int, rows: int) -> GreyView:
    """Return the small grey view of at most (rows, columns)."""
    return GreyView(np.rint(shrunk(panorama, columns, rows)).astype(np.uint8), panorama.rig)


def fitted_image_flow(current: GreyView, goal: GreyView, rounds: int = ROUNDS) -> tuple[Flow, float]:
    """Fit a sin t + b cos t + c and v (a cos t - b sin t) to the flow goal -> current; return it with the share that
    fits.
    """
    fit, trust = _robust(*_equations(around_flow(goal.picture, current.picture), goal), rounds)
    return Flow(math.atan2(-fit[1], fit[0]), math.hypot(fit[0], fit[1]), float(fit[2])), trust


def _equations(flow: FloatArray, goal: GreyView) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the template (2 N, 3), the flow (2 N,) [rad; slope] and the texture (2 N,) that carries it.

    First all sideways, then all upward components: elevation counts up while rows run down.
    """
    rows, columns = goal.picture.shape
    t = np.arange(columns) * (TAU / columns) + 0.5 * (TAU / columns - TAU / goal.rig.width)
    row = (np.arange(rows) + 0.5) * goal.rig.height / rows - 0.5
    v = np.repeat((goal.rig.horizon_row - row) / goal.rig.focal, columns)
    sin, cos = np.tile(np.sin(t), rows), np.tile(np.cos(t), rows)
    one, zero = np.ones_like(v), np.zeros_like(v)
    design = np.concatenate([np.stack([sin, cos, one], 1), np.stack([v * cos, -v * sin, zero], 1)])
    sideways = flow[:, :, 0].ravel() * (TAU / columns)
    upward = -flow[:, :, 1].ravel() * (goal.rig.height / rows / goal.rig.focal)
    slope = np.abs(np.roll(goal.picture, -1, 1).astype(np.float64) - np.roll(goal.picture, 1, 1)).ravel()
    rise = np.abs(np.gradient(goal.picture.astype(np.float64), axis=0)).ravel()
    return design, np.concatenate([sideways, upward]), np.concatenate([slope, 2.0 * rise])


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
    start[:, :, 0] = cv2.medianBlur(_around(coarse[np.newaxis].astype(np.float32), SEAM), 5)[:, SEAM:-SEAM]
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
