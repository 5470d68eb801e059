"""H26, H27: home vectors from columns matched by dynamic time warping (chapter 5.1.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from topomap.errors import ShapeError
from topomap.geometry import TAU, FloatArray
from topomap.types import Float32Array, HomeVector
from topomap.vision.homing.needs import Needs
from topomap.vision.kernels import dtw_path
from topomap.vision.panorama import Panorama
from topomap.vision.ring import RING, RingSpec, ring
from topomap.vision.stationary import FLOW, FlowSpec, fitted_flow


@dataclass(frozen=True, slots=True)
class RingPair:
    """What the method keeps of a panorama: fine (F, C) for matching, coarse (F, C') for the flow, and the
    bearing [rad] of fine's column 0.
    """

    fine: Float32Array
    coarse: Float32Array
    first_bearing: float


@dataclass(frozen=True, slots=True)
class Match:
    """A home vector with the cost of the matching: 0 same, about 1 (the mirrored goal's) unrelated."""

    home: HomeVector
    cost: float


@dataclass(frozen=True, slots=True)
class DynamicWarping:
    """sum over home bearings of [u(matched current bearing) - u(home bearing)] (5.15, 5.16, whose printed
    sign is reversed); bearing only; needs aligned views.

    wings: "unifying" matches once around from the diffusion point (H27), "wing" each side from the diffusion
    to the convergence point (H26); band [rad]: Sakoe-Chiba's, how far a column may move.
    """

    needs: ClassVar[Needs] = Needs(compass=True)
    claims_homing: ClassVar[bool] = True
    wings: Literal["unifying", "wing"] = "unifying"
    spec: RingSpec = RING
    flow: FlowSpec = FLOW
    flow_columns: int = 180
    band: float = math.radians(50.0)

    def describe(self, panorama: Panorama) -> RingPair:
        """Return the rings the matching runs on."""
        spec = self.spec
        coarse = RingSpec(self.flow_columns, spec.bands, spec.top, spec.bottom, spec.blur, spec.colour)
        fine = ring(panorama, spec)
        first_bearing = 0.5 * (TAU / fine.shape[1] - TAU / panorama.rig.width)
        return RingPair(fine, ring(panorama, coarse), first_bearing)

    def home(self, current: RingPair, goal: RingPair) -> HomeVector:
        """Return the bearing [rad] of the goal in the aligned frame."""
        return self.match(current, goal).home

    def match(self, current: RingPair, goal: RingPair) -> Match:
        """Return the home vector and the cost of the matching, to verify that two views show one place.

        Raises ShapeError.
        """
        if current.fine.shape != goal.fine.shape:
            raise ShapeError(f"rings differ in shape: {current.fine.shape} and {goal.fine.shape}")
        ahead = fitted_flow(current.coarse, goal.coarse, self.flow).direction
        start = round(ahead * goal.fine.shape[1] / TAU)
        shift, cost = self._matched(current.fine, goal.fine, start)
        first = start * TAU / len(shift) + goal.first_bearing
        _, mirrored = self._matched(current.fine, np.ascontiguousarray(goal.fine[:, ::-1]), start)
        relative = cost / mirrored if mirrored > 1e-9 else 1.0
        return Match(_home(shift, first, relative), relative)

    def _matched(self, current: Float32Array, goal: Float32Array, start: int) -> tuple[FloatArray, float]:
        """Return how far each goal column, from `start` on, has moved [rad], (C,), and the mean cost."""
        columns = goal.shape[1]
        band = min(max(round(self.band * columns / TAU), 1), columns - 1)
        here, there = np.roll(current, -start, axis=1), np.roll(goal, -start, axis=1)
        if self.wings == "unifying":
            shift, cost = dtw_path(there, here, band)
            return shift * (TAU / columns), cost
        half = columns // 2
        pieces = [dtw_path(_piece(there, k, half), _piece(here, k, half), min(band, half - 1)) for k in (0, 1)]
        return np.concatenate([p[0] for p in pieces]) * (TAU / columns), (pieces[0][1] + pieces[1][1]) / 2


def _piece(rings: Float32Array, k: int, half: int) -> Float32Array:
    return np.ascontiguousarray(rings[:, :half] if k == 0 else rings[:, half:])


def _home(shift: FloatArray, first: float, cost: float) -> HomeVector:
    columns = len(shift)
    bearings = np.arange(columns) * (TAU / columns) + first
    x = float(np.sum(np.cos(bearings + shift) - np.cos(bearings))) / columns
    y = float(np.sum(np.sin(bearings + shift) - np.sin(bearings))) / columns
    sure = min(max(1.0 - cost, 0.0), 1.0) if math.hypot(x, y) > 1e-6 else 0.0
    return HomeVector(math.atan2(y, x), None, sure)
